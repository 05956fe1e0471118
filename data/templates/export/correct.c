/*
@comment@ *
 * Compile with -D@PREFIX@_FLOAT for single precision, with -D@PREFIX@_SELF_TEST for a program that checks itself (link with -lm).
 */
@header@
#include <float.h>
#include <math.h>
#include <stddef.h>

#ifdef @PREFIX@_FLOAT
#define @PREFIX@_MATH(function) function##f
#define @PREFIX@_EPSILON FLT_EPSILON
#else
#define @PREFIX@_MATH(function) function
#define @PREFIX@_EPSILON DBL_EPSILON
#endif

@parameters@
/* inputs = matrix * (readings - bias), to first order */
const @prefix@_real @prefix@_bias[@PREFIX@_SENSORS] = @bias@;
static const @prefix@_real @prefix@_matrix[@PREFIX@_INPUTS][@PREFIX@_SENSORS] = @matrix@;
const @prefix@_real @prefix@_otherwise[@PREFIX@_GIVEN + 1] = @otherwise@;

static inline @prefix@_real @prefix@_sign(@prefix@_real x) { return (@prefix@_real)((x > 0) - (x < 0)); }
static inline @prefix@_real @prefix@_step(@prefix@_real x) { return (@prefix@_real)(x >= 0); }
static inline @prefix@_real @prefix@_whole_power(@prefix@_real x, int n)
{
    @prefix@_real power = 1;
    int k;
    for (k = 0; k < (n < 0 ? -n : n); k++)
        power *= x;
    return n < 0 ? 1 / power : power;
}

/* Components x along the axes of the lines. */
static void @prefix@_axes(const @prefix@_real q[], const @prefix@_real given[], @prefix@_real x[])
{
    (void)given;
@axes@}

/* The model lines: readings s of all sensors for inputs q. */
static void @prefix@_lines(const @prefix@_real q[], const @prefix@_real given[], @prefix@_real s[])
{
    @prefix@_real x[@count@];
    @prefix@_axes(q, given, x);
    (void)@prefix@_sign, (void)@prefix@_step, (void)@prefix@_whole_power;
@lines@}

/* Their slopes d by the inputs. */
static void @prefix@_slopes(const @prefix@_real q[], const @prefix@_real given[], @prefix@_real d[][@PREFIX@_INPUTS])
{
    @prefix@_real x[@count@];
    @prefix@_axes(q, given, x);
@slopes@}

/* Replace x by the solution of a y = x: elimination with the largest pivots. */
static void @prefix@_solve(@prefix@_real a[][@PREFIX@_INPUTS], @prefix@_real x[])
{
    int i, j, k;
    for (k = 0; k < @PREFIX@_INPUTS; k++) {
        int largest = k;
        for (i = k + 1; i < @PREFIX@_INPUTS; i++)
            if (@PREFIX@_MATH(fabs)(a[i][k]) > @PREFIX@_MATH(fabs)(a[largest][k]))
                largest = i;
        for (j = 0; j < @PREFIX@_INPUTS; j++) {
            const @prefix@_real kept = a[k][j];
            a[k][j] = a[largest][j];
            a[largest][j] = kept;
        }
        {
            const @prefix@_real kept = x[k];
            x[k] = x[largest];
            x[largest] = kept;
        }
        for (i = k + 1; i < @PREFIX@_INPUTS; i++) {
            const @prefix@_real share = a[i][k] / a[k][k];
            for (j = k; j < @PREFIX@_INPUTS; j++)
                a[i][j] -= share * a[k][j];
            x[i] -= share * x[k];
        }
    }
    for (k = @PREFIX@_INPUTS - 1; k >= 0; k--) {
        for (j = k + 1; j < @PREFIX@_INPUTS; j++)
            x[k] -= a[k][j] * x[j];
        x[k] /= a[k][k];
    }
}

int @prefix@_correct(const @prefix@_real readings[], const @prefix@_real given[], @prefix@_real inputs[])
{
    @prefix@_real size[@PREFIX@_INPUTS], last = (@prefix@_real)INFINITY;
    int round, newton = 0, i, j, k, result = @PREFIX@_NOT_SETTLED;
    for (i = 0; i < @PREFIX@_INPUTS; i++) {
        inputs[i] = 0;
        size[i] = 0;
        for (j = 0; j < @PREFIX@_SENSORS; j++)
            size[i] += @PREFIX@_MATH(fabs)(@prefix@_matrix[i][j] * readings[j]);
    }
    if (@PREFIX@_GIVEN > 0 && given == NULL)
        result = @PREFIX@_NOT_GIVEN;
    for (round = 0; round < @rounds@ && result == @PREFIX@_NOT_SETTLED; round++) {
        @prefix@_real at[@PREFIX@_SENSORS], step[@PREFIX@_INPUTS], change = 0;
        @prefix@_lines(inputs, given, at);
        for (i = 0; i < @PREFIX@_INPUTS; i++) {
            step[i] = 0;
            for (j = 0; j < @PREFIX@_SENSORS; j++)
                step[i] += @prefix@_matrix[i][j] * (readings[j] - at[j]);
        }
        if (newton) {
            @prefix@_real slopes[@PREFIX@_SENSORS][@PREFIX@_INPUTS] = {{0}}, a[@PREFIX@_INPUTS][@PREFIX@_INPUTS];
            @prefix@_slopes(inputs, given, slopes);
            for (i = 0; i < @PREFIX@_INPUTS; i++)
                for (k = 0; k < @PREFIX@_INPUTS; k++) {
                    a[i][k] = 0;
                    for (j = 0; j < @PREFIX@_SENSORS; j++)
                        a[i][k] += @prefix@_matrix[i][j] * slopes[j][k];
                }
            @prefix@_solve(a, step);
        }
        for (i = 0; i < @PREFIX@_INPUTS; i++) {
            const @prefix@_real to = @PREFIX@_MATH(fabs)(inputs[i] + step[i]);
            const @prefix@_real share = @PREFIX@_MATH(fabs)(step[i]) / (to > size[i] ? to : size[i]);
            if (!isfinite(step[i]))
                goto end;
            if (share > change)
                change = share;
        }
        if (!newton && change > 4 * @PREFIX@_EPSILON && (change >= last || round >= @contracting@)) {
            newton = 1;
            continue;
        }
        for (i = 0; i < @PREFIX@_INPUTS; i++)
            inputs[i] += step[i];
        if (change <= (newton ? 16 : 4) * @PREFIX@_EPSILON)
            result = @PREFIX@_DONE;
        last = change;
    }
end:
    for (i = 0; i < @PREFIX@_INPUTS && result != @PREFIX@_DONE; i++)
        inputs[i] = (@prefix@_real)NAN;
    return result;
}

#ifdef @PREFIX@_SELF_TEST
#include <stdio.h>

enum { @PREFIX@_SAMPLES = @samples@ };
static const @prefix@_real @prefix@_test_readings[@PREFIX@_SAMPLES][@PREFIX@_SENSORS] = @test_readings@;
static const @prefix@_real @prefix@_test_given[@PREFIX@_SAMPLES][@PREFIX@_GIVEN + 1] = @test_given@;
static const @prefix@_real @prefix@_test_inputs[@PREFIX@_SAMPLES][@PREFIX@_INPUTS] = @test_inputs@;

int main(void)
{
    int k, i, j, failed = 0;
    for (k = 0; k < @PREFIX@_SAMPLES; k++) {
        @prefix@_real q[@PREFIX@_INPUTS];
        if (@prefix@_correct(@prefix@_test_readings[k], @prefix@_test_given[k], q) != @PREFIX@_DONE)
            failed = 1;
        for (i = 0; i < @PREFIX@_INPUTS; i++) {
            @prefix@_real size = @PREFIX@_MATH(fabs)(q[i]), sum = 0;
            for (j = 0; j < @PREFIX@_SENSORS; j++)
                sum += @PREFIX@_MATH(fabs)(@prefix@_matrix[i][j] * @prefix@_test_readings[k][j]);
            printf(i + 1 < @PREFIX@_INPUTS ? "%.12g " : "%.12g\n", (double)q[i]);
            if (!(@PREFIX@_MATH(fabs)(q[i] - @prefix@_test_inputs[k][i]) <= 1000 * @PREFIX@_EPSILON * (sum > size ? sum : size)))
                failed = 1;
        }
    }
    fprintf(stderr, failed ? "self-test failed\n" : "self-test passed\n");
    return failed;
}
#endif
