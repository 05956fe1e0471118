@comment@#
# Run this file to check it against its own test samples.
"""Correction of a calibrated unit: correct(readings) gives the inputs."""

import math
import sys

@parameters@
# inputs = MATRIX (readings - BIAS), to first order
BIAS = @bias@
MATRIX = @matrix@
# values of the given inputs where none are given
OTHERWISE = @otherwise@


def _sign(x):
    return float(x > 0) - float(x < 0)


def _step(x):
    return float(x >= 0)


def _whole_power(x, n):
    power = 1.0
    for _ in range(abs(n)):
        power *= x
    return 1 / power if n < 0 else power


def _axes(q, given):
    x = [0.0] * @count@
@axes@    return x


def lines(q, given=OTHERWISE):
    """The model lines: readings of all sensors for inputs q."""
    s, x = [0.0] * @sensors@, _axes(q, given)
@lines@    return s


def slopes(q, given=OTHERWISE):
    """Slopes of the model lines by the inputs."""
    d, x = [[0.0] * @inputs@ for _ in range(@sensors@)], _axes(q, given)
@slopes@    return d


def _solve(a, x):
    """The solution y of a y = x: elimination with the largest pivots."""
    a, n = [row + [value] for row, value in zip(a, x)], len(x)
    for k in range(n):
        largest = max(range(k, n), key=lambda i: abs(a[i][k]))
        a[k], a[largest] = a[largest], a[k]
        for i in range(k + 1, n):
            share = a[i][k] / a[k][k]
            a[i] = [to - share * by for to, by in zip(a[i], a[k])]
    y = [0.0] * n
    for k in reversed(range(n)):
        y[k] = (a[k][n] - sum(a[k][j] * y[j] for j in range(k + 1, n))) / a[k][k]
    return y


def correct(readings, given=OTHERWISE):
    """Inputs for one sample of readings; ArithmeticError where the iteration does not settle."""
    try:
        return _correct(readings, given)
    except (ValueError, OverflowError, ZeroDivisionError):  # outside the domain of a line
        raise ArithmeticError("the correction does not settle for these readings") from None


def _correct(readings, given):
    q, newton, last = [0.0] * @inputs@, False, math.inf
    size = [sum(abs(c * s) for c, s in zip(row, readings)) for row in MATRIX]
    for count in range(@rounds@):
        rest = [s - f for s, f in zip(readings, lines(q, given))]
        step = [sum(c * r for c, r in zip(row, rest)) for row in MATRIX]
        if newton:
            columns = list(zip(*slopes(q, given)))
            step = _solve([[sum(c * d for c, d in zip(row, column)) for column in columns] for row in MATRIX], step)
        if not all(map(math.isfinite, step)):
            break
        sizes = [max(abs(x + dx), s) for x, dx, s in zip(q, step, size)]
        change = max(abs(dx) / s if s else math.inf if dx else 0.0 for dx, s in zip(step, sizes))
        if not newton and change > 4 * sys.float_info.epsilon and (change >= last or count >= @contracting@):
            newton = True
            continue
        q = [x + dx for x, dx in zip(q, step)]
        if change <= (16 if newton else 4) * sys.float_info.epsilon:
            return q
        last = change
    raise ArithmeticError("the correction does not settle for these readings")


TEST_READINGS = @test_readings@
TEST_GIVEN = @test_given@
TEST_INPUTS = @test_inputs@


def self_test():
    for readings, given, inputs in zip(TEST_READINGS, TEST_GIVEN, TEST_INPUTS):
        q = correct(readings, given)
        print(*("%.12g" % x for x in q))
        for row, x, truth in zip(MATRIX, q, inputs):
            size = max(abs(x), sum(abs(c * s) for c, s in zip(row, readings)))
            if not abs(x - truth) <= 1000 * sys.float_info.epsilon * size:
                raise AssertionError("self-test failed")
    print("self-test passed", file=sys.stderr)


if __name__ == "__main__":
    self_test()
