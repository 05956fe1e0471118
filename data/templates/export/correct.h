#ifndef @PREFIX@_CORRECT_H
#define @PREFIX@_CORRECT_H

#ifdef __cplusplus
extern "C" {
#endif

#ifdef @PREFIX@_FLOAT
typedef float @prefix@_real;
#else
typedef double @prefix@_real;
#endif

enum { @PREFIX@_SENSORS = @sensors@, @PREFIX@_INPUTS = @inputs@, @PREFIX@_GIVEN = @given@ };

/* What @prefix@_correct returns: done; the iteration does not converge for these readings; values that must be given are not. */
enum { @PREFIX@_DONE = 0, @PREFIX@_NOT_SETTLED = -1, @PREFIX@_NOT_GIVEN = -2 };

/* Readings at zero input. */
extern const @prefix@_real @prefix@_bias[@PREFIX@_SENSORS];

/* Values of the given inputs where none are given: their means in the calibration. */
extern const @prefix@_real @prefix@_otherwise[@PREFIX@_GIVEN + 1];

/* Inputs for one sample of readings; `given` may be null only where @PREFIX@_GIVEN is 0. Unless it is done, the inputs are not-a-number. */
int @prefix@_correct(const @prefix@_real readings[], const @prefix@_real given[], @prefix@_real inputs[]);

#ifdef __cplusplus
}
#endif

#endif
