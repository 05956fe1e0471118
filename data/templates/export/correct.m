function [q, settled] = @prefix@_correct(readings, given)
@comment@%
% Keep this file as @prefix@_correct.m. @prefix@_correct('self-test') checks it against its own samples.
% inputs = matrix * (readings - bias), to first order
bias = @bias@;
matrix = @matrix@;
if ischar(readings)
    self_test(matrix);
    q = []; settled = true;
    return
end
if nargin < 2
    given = @otherwise@;
end
readings = readings(:);
q = zeros(@inputs@, 1);
size_of = abs(matrix) * abs(readings);
settled = false;
newton = false;
last = Inf;
for count = 0:@rounds@ - 1
    at = lines(q, given);
    step = matrix * (readings - at);
    if newton
        [step, singular] = linsolve(matrix * slopes(q, given), step);
    end
    if ~isreal(step) || ~all(isfinite(step))
        break
    end
    share = abs(step) ./ max(abs(q + step), size_of);
    share(step == 0) = 0;
    change = max(share);
    if ~newton && change > 4 * eps && (change >= last || count >= @contracting@)
        newton = true;
        continue
    end
    q = q + step;
    if change <= (4 + 12 * newton) * eps
        settled = true;
        break
    end
    last = change;
end
if ~settled
    q(:) = NaN;
end
end

function x = axes_of(q, given)
% Components along the axes of the lines.
x = zeros(@count@, 1);
@axes@end

function s = lines(q, given)
% The model lines: readings of all sensors for inputs q.
x = axes_of(q, given);
s = zeros(@sensors@, 1);
@parameters@@lines@end

function d = slopes(q, given)
% Slopes of the model lines by the inputs.
x = axes_of(q, given);
d = zeros(@sensors@, @inputs@);
@parameters@@slopes@end

function p = whole_power(x, n)
p = 1;
for k = 1:abs(n)
    p = p * x;
end
if n < 0
    p = 1 / p;
end
end

function self_test(matrix)
readings = @test_readings@;
given = @test_given@;
inputs = @test_inputs@;
for k = 1:@samples@
    [q, settled] = @prefix@_correct(readings(k, :), given(k, :));
    fprintf('%.12g ', q(1:end-1));
    fprintf('%.12g\n', q(end));
    limit = 1000 * eps * max(abs(q), abs(matrix) * abs(readings(k, :)'));
    if ~settled || any(abs(q - inputs(k, :)') > limit)
        error('self-test failed');
    end
end
end
