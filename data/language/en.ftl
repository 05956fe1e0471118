# Sentences and terms of the reports in English. Arguments are formatted before they come here.

## Punctuation

mark-comma = { ", " }
mark-clause = { ", " }
mark-semicolon = { "; " }
mark-colon = { ": " }
mark-stop = { "." }
mark-space = { " " }
in-parentheses = ({ $text })
has-capitals = yes

## Lists and counts

list-and = { $before } and { $last }
count-reading = { $n ->
    [one] { $n } reading
   *[other] { $n } readings
}
count-prior = { $n ->
    [one] { $n } prior
   *[other] { $n } priors
}
count-iteration = { $n ->
    [one] { $n } iteration
   *[other] { $n } iterations
}
count-parameter = { $n ->
    [one] { $n } parameter
   *[other] { $n } parameters
}
count-degree = { $n ->
    [one] { $n } degree of freedom
   *[other] { $n } degrees of freedom
}

## Closed vocabularies of the reports, as JSON has them

term = { $word ->
    [not-estimable] not estimable
    [at-bound] at a bound
    [fixed] fixed by equations
    [at-limit] active
    [not-applied] not applied
    [left-out] not applied
    [wrong] contradicted by the readings
    [effects-found] effects found
    [partly-explained] partly explained
    [nothing-missing] nothing missing
    [not-diagnosable] not diagnosable
    [stuck-channel] stuck channel
    [global-test] global test failed
    [no-convergence] no convergence
    [lack-of-fit] lack of fit
    [suspicious-readings] suspicious readings
    [repeated-rows] repeated rows
    [outside-limits] outside limits
    [turned-180] a joint turned by 180 degrees
    [another-position] another position of the schedule
    [wrong-sense] a rate of the wrong sense
    [exchanged-axes] exchanged joints
    [exchanged-sensors] exchanged sensors
    [slipped-mounting] a mounting that slipped
    [bad-reading] a wrong value
    [missing-effect] an effect that the model lacks
   *[other] { $word }
}

# report/fit_table.rs
derived = derived
parameter = parameter
estimate = estimate
dof = dof
unit = unit
state = state
record-of-rows-read = Record of { $rows } rows; { $shown } of them are in the table of readings and in the figures.
rows-in-a-mean = rows in a mean
sd-over-that-of-independent-rows = sd / sd of independent rows
row-of-the-record = row
that-of-rounding-to-its-last-digit = { $beyond ->
    [yes] from rounding to { $step } (the last digit, divided by sqrt 12); beyond the lines of scatter, the variance of the readings is estimated as zero
   *[no] from rounding to { $step } (the last digit, divided by sqrt 12); the readings do not scatter more than this
}
the-rounding-of-its-readings-which-show = { $beyond ->
    [yes] from the rounding of the readings, which show no scatter beyond the lines of scatter
   *[no] from the rounding of the readings, which show no scatter
}
residual-sd-of = { $per_sample ->
    [yes] Residual standard deviation of one sample of `{ $sensor }`
   *[no] Residual standard deviation of `{ $sensor }`
}: { $sd }.
inconsistent-disagrees-with-the-other-sights-by = `{ $sensor }` is inconsistent: it disagrees with the other sights by { $mean_residual_deg } deg on average. Check for another side of the target, a wrong point, or a starting value that is too far away.
correlated-inputs = correlated: { $list }
no-reading-responds-to-at-the-reference = No reading responds to { $moved } at the reference point, because every factor that multiplies it is zero there: the iteration started from a point nearby.
held-where-the-iteration-began-since-the = Held at the starting value, because the exact model determines them only weakly away from it: { $held }.
gauss-newton-converged-after = { $differs ->
    [yes] Gauss-Newton converged after { $steps }; the linear estimates (one step from the reference point) differ by more than 0.1 u (converged minus linear): { $what }.
   *[no] Gauss-Newton converged after { $steps }; the linear estimates (one step from the reference point) agree within 0.1 u.
}
u-holds-only-for-as-held-another = U is valid only for the held value of `{ $held }`: a change of it by { $by } shifts the estimates ({ $shifts }).
derived-without-a-value = derived quantities without a value (they depend on parameters that are not estimable, or are undefined at the solution): { $names }
no-reading-responds = { $here ->
    [yes] no reading responds to it at this point
   *[no] no reading responds to it
}
a-reading-would-separate = { $what ->
    [position] a reading at { $keys } would separate them
    [sensor] a reading of { $sensor } would separate them
   *[both] a reading of { $sensor } at { $keys } would separate them
}
reading = reading
position = position
sensor = sensor
value = value
fitted = fitted
residual = residual
studentized = studentized
redundancy = redundancy
mdb = mdb

# report/fit_checks_table.rs
combined = combined
quantity = quantity
type = type
distribution = distribution
contribution = contribution
share = share
correlation = correlation
is-at-a-bound-interval-to-of = `{ $id }` is at a bound: { $level } interval { $low } to { $high } { $unit } (that of the unconstrained estimate, truncated at the bounds).
is-at-a-bound-and-the-whole = `{ $id }` is at a bound, and the { $level } interval of the unconstrained estimate is entirely outside the bounds: bounds and readings are inconsistent.
monte-carlo = Monte Carlo
mean = mean
coverage-ellipsoid-of-k-p = coverage ellipsoid of { $order }: k_p = { $k }
scale-factor-errors-are-not-drawn = not included in the Monte Carlo trials: { $errors }

# report/correction.rs
the-lines-are-linear-in-the-inputs = The model lines are linear in the inputs, so this correction is exact.
within-the-range-of-the-calibration-it = Within the range of the calibration ({ $within }), the error of the first-order correction is at most { $errors }
below-the-standard-uncertainty-of-the-calibration = , below the standard uncertainty of the calibration in the whole range.
none = none
within-of-that-range-it-stays-below = ; it is below the standard uncertainty of the calibration in { $part } of that range. Where it is larger, use the exact model lines, as `tumble apply` does.
correction-otherwise = { $id } (default { $otherwise })
correction-is-for = Bias and matrix apply at { $at }; at other values they follow from the model of the sensors.
these-sensors-do-not-determine-give-it = Inputs that these sensors do not determine, to be given as columns of the record: { $given }.
correction-none-of-the-sensors-follows-a = no correction: no sensor measures a rate w_* or a specific force a_* that the fit determines
input = input
bias = bias

# report/html/fit_page.rs
made-by = made by
sha-of = SHA-256 of { $name }
bench = Bench
source = source
model = Model
estimator = Estimator
residuals-and-correlations = Residuals and correlations

# report/html/fit_answer.rs
result = Result
global-test-chi-square-with-p = Global test: { $rejected ->
    [yes] the residuals exceed the stated uncertainties of the readings: the model is incomplete, or the uncertainties are too small
    [less] the residuals are smaller than the stated uncertainties of the readings: these are too large, or the readings are not independent
   *[no] the residuals agree with the stated uncertainties of the readings
} (chi-square { $chi_square } with { $dof }, p = { $p }).
the-readings-state-no-uncertainty-of-their = No uncertainty is stated for the readings: their standard deviation is estimated from the residuals, so these readings alone cannot test the model.
no-degrees-of-freedom-the-readings-just = No degrees of freedom: there are only as many readings as estimable parameters, so the model cannot be tested.
one-linear-step-is-not-enough-gauss = One linear step is not enough: further Gauss-Newton steps would change these estimates by more than 0.1 u: { $what }. Fit without `--linear`.
from-the-fit-estimates-rank-of-freedom = From { $from } the fit estimates { $parameters } (rank { $rank }, { $dof }).
the-scaled-design-matrix-has-condition-number = The scaled design matrix has condition number { $condition }.

# report/html/fit_correction.rs
the-correction-to-apply = The correction to apply
readings-cannot-be-corrected-not-estimable-here = Readings cannot be corrected: { $missing } { $n ->
    [one] is
   *[other] are
} not estimable here.
all-sensors-are-solved-together-for-the = All sensors are solved together for the inputs that they determine. To first order:
is-left-out-of-the-correction = `{ $sensor }` is left out of the correction: { $why }.
the-rotation-from-the-sensors-axes-to = The rotation from the sensors' axes to the mounting face needs { $tilts }; { $missing } { $n ->
    [one] is
   *[other] are
} not estimable here.
direction-cosines-of-the-corrected-inputs-on = Direction cosines of the corrected inputs on the mounting face
a-corrected-input-points-along-the-sensors = Corrected inputs are components along the sensors' axes. These axes are rotated from the mounting face (the frame after the last joint) by { $tilts }; a rate or force known in that frame is converted by these direction cosines:

# report/html/fit_estimates.rs
angle = angle
coefficient = coefficient
u-combined-standard-uncertainty-k-u-expanded = u: combined standard uncertainty; { $expanded } = k u: expanded uncertainty, k from Student's t with ν effective degrees of freedom.
estimates = Estimates
not-estimable-from-these-readings = Not estimable from these readings
the-parameters-can-move-along-and-no = A change of the parameters along `{ $text }` changes no reading; { $instead }.
determined-instead = determined instead
where-the-uncertainty-comes-from = Sources of uncertainty
u-of-source = u of source
angles-in-radians-c-sensitivity-coefficient-of = Contributions in the unit of the estimate (angles in arcsec), u of source in the unit of the source (angles in rad). c: sensitivity coefficient of a single source; ν: degrees of freedom; share: part of the variance.
below-of-the-variance-left-out = Not listed, because below 0.05 % of the variance: { $hidden }.

# report/html/fit_figures.rs
angles-with-their-expanded-uncertainties = Angles with their expanded uncertainties ({ $level }).
standard-uncertainties-divided-by-each-sources-share = Standard uncertainties; bars are divided by the share of each source in the variance.
standard-uncertainty = standard uncertainty
coefficients-each-sources-share-of-the-variance = Coefficients: each source's share of the variance. Sources below 0.5 % are left white.
residuals-of-figure = { $shared ->
    [yes] Residuals of { $id }, random effects common to several readings removed, and bands of two standard deviations. Readings beyond { $limit } standard deviations (diamonds): { $far }.
   *[no] Residuals of { $id } and bands of two standard deviations. Readings beyond { $limit } standard deviations (diamonds): { $far }.
}
normal-plot-of-the-studentized-residuals-with = Normal plot of the studentized residuals with its pointwise 95 % band: normal residuals follow the line.
correlations-of-the-estimates-in-hundredths-blue = Correlations of the estimates, in hundredths: blue positive, orange negative, crosses where not estimable.

# report/html/fit_readings.rs
taken-as-zero-neither-known-nor-estimated = Assumed zero, neither known nor estimated: { $assumed_zero }.
site-latitude-earth-rate-deg-h = Site: latitude { $latitude_deg }°, Earth rate { $earth_rate_deg_h } deg/h, { $said }.
no-site-no-earth-rate-and-gravity = No site is given: Earth rate assumed zero, gravity assumed 9.80665 m/s^2 (1 g).
rows-are-exact-derivatives = { $iterated ->
    [yes] Exact: rows of the design matrix are exact derivatives, iterated to the solution.
   *[no] Linear: rows of the design matrix are exact derivatives at the reference point; one step from it.
}
errors-are-independent = Apart from random effects that are listed, the readings of one sensor have independent errors of equal standard deviation, estimated from the residuals.
known = known
exact = exact
what-was-assumed = What was assumed
redundancy-the-share-of-a-fault-that = Redundancy: the share of an error of the reading that appears in its residual. MDB: minimal detectable bias, the smallest error that a test at 0.1 % finds with a power of 80 %. Marked: studentized residual beyond { $limit }.
the-first-of-are-listed-the-json = The first { $listed } of { $n } are listed.
readings = Readings

# report/html/checks_page.rs
the-robust-estimator-did-not-settle = The robust estimator ({ $method }) did not converge.
checks = Checks
test = test
statistic = statistic
lack-of-fit = lack of fit
lack-of-fit-by-position = lack of fit by position
runs-of = runs of `{ $sensor }`
runs-in-the-order-of = runs of `{ $sensor }` in the order of `{ $column }`
runs-expected = { $runs } runs, { $expected } expected
normality = normality
shift = shift
shift-how-far-the-reading-is-off = Shift: difference between the reading and its prediction from the other readings. p: corrected for { $tested } tests (Sidak).
change-without-suspects = change without suspicious readings
external-reliability = External reliability
effect-what-the-smallest-detectable-fault-of = Shift: largest change of the parameter by an error of one reading equal to its minimal detectable bias; reading: the reading that causes it.
constraints-and-weights = Constraints and weights
constraint = constraint
side = side
cost-in-chi-square = increase of chi-square
less-than-half-of-their-weight-readings = Readings with a weight below one half: { $low }.
checks-page-interval = interval ({ $level })
shortest = shortest
first-order = first order
of-trials-seed = { $trials } of { $asked } trials, seed { $seed }.
marked-the-first-order-is-not-good = { $trials } Marked: the first-order interval is not correct to two digits of the uncertainty.

# report/html/conformity_page.rs
conformity = Conformity
lower-limit = lower limit
upper-limit = upper limit
probability = probability
probability-that-the-quantity-is-inside-its = Probability: that the quantity is inside its limits, by Student's t about the estimate (JCGM 106, 7.3).

# report/html/scatter_page.rs
what-scatters = Random effects
sd-standard-deviation-of-one-deviation-a = sd: standard deviation of a single deviation, stated by the campaign or estimated from these readings (restricted maximum likelihood). The uncertainties include each source.

# report/plot/normal.rs
normal-quantile = normal quantile
studentized-residual = studentized residual

# report/plot/values.rs
estimate-and-expanded-uncertainty = estimate and expanded uncertainty

# report/plot/bars.rs
bars-type = { $name } (Type { $type_b })

# report/html/compare_page.rs
comparison-with-the-published-closed-forms = Comparison with the published closed forms
group-by-group-without-earth-rate = { $square ->
    [yes] Group by group and without the Earth rate, which they neglect, the formulas agree with least squares to { $difference } of the value: they are least squares of an exactly determined system.
   *[no] Group by group and without the Earth rate, which they neglect, the formulas differ from least squares by up to { $difference } of the value: these positions do not give an exactly determined system.
}
printed = printed
closed-form = closed form
least-squares-no-earth-rate = least squares, no Earth rate
least-squares = least squares
all = all
group-by-group = Group by group
computed = computed
probable-cause = probable cause
misprints-found = Misprints found

# report/compare_table.rs
closed-form-and-least-squares-differ-by = closed form and least squares differ by at most { $difference } of the value.

# report/site.rs
altitude-of = altitude { $altitude } m
site-gravity = gravity: { $gravity } { $unit }{ $u }{ $from }

# report/conformity.rs
simple-acceptance-the-estimate-inside-the-limits = simple acceptance: the estimate inside the limits (JCGM 106, 8.2)
guard-band-w-u-pass-inside-by = guard band w = U ({ $percent } %): pass inside by U, fail outside by U (JCGM 106, 8.3)
specific-risk-pass-where-conformity-is-at = specific risk: pass where conformity is at least { $percent } % probable, fail where non-conformity is (JCGM 106, 7)

# report/site.rs
gravity-is-not-stated-and-taken-as = gravity is not stated and taken as { $standard_gravity_m_s2 } m/s^2; local gravity differs by up to 3000 ppm, and so do coefficients for m/s^2: give site.gravity, or site.latitude_deg with site.altitude_m

# report/scatter.rs
estimated-as-zero = { $below ->
    [yes] estimated as zero: the residuals show no variance due to it; u and dof do not assume that it is zero
   *[no] estimated as zero: the residuals show no variance due to it
}
no-reading-feels-it-here = no reading depends on it here
these-readings-cannot-tell-it-from-their = these readings cannot distinguish it from { $named ->
    [yes] { $others }
   *[no] the other random effects
}: the sum of the variances is used; repeated readings at one level would separate them
the-unknowns-take-up-its-deviations = its { $count ->
    [one] one deviation is
   *[other] { $count } deviations are
} absorbed by the estimated parameters, so that its size cannot be estimated and u of { $names } cannot be given: { $levels }
more-levels = { $per ->
    [reading] { $more ->
        [one] at least one more reading at the inputs of others is needed
       *[other] at least { $more } more readings at the inputs of others are needed
    }
    [position] { $more ->
        [one] at least one new mounting (a position measured again) is needed
       *[other] at least { $more } new mountings (positions measured again) are needed
    }
    [campaign] { $more ->
        [one] readings of at least one more campaign are needed, with a column that numbers the campaigns
       *[other] readings of at least { $more } more campaigns are needed, with a column that numbers the campaigns
    }
   *[other] { $more ->
        [one] readings with at least one more value of { $per } are needed
       *[other] readings with at least { $more } more values of { $per } are needed
    }
}
no-degrees-of-freedom-are-left-to = no degrees of freedom are left to estimate it
in-each-reading-as-stated = in each reading as stated

# report/separation.rs
beyond-this-point-readings-respond-to-it = readings depend on it only in second order, or through a parameter that is zero or nearly zero here: state a value, a prior or a start
no-position-of-this-bench-would-separate-2 = no position of this bench would separate them
hides-in-and = { $last } is absorbed by { $join } and { $before }

# report/fit_checks.rs
lack-of-fit-by-replicates = { $rejected ->
    [yes] LACK OF FIT: the residuals exceed the scatter of replicates ({ $test }, p = { $p })
   *[no] the residuals agree with the scatter of replicates ({ $test }, p = { $p })
}
lack-of-fit-between-positions = { $rejected ->
    [yes] LACK OF FIT by position: the mean residuals of positions exceed the scatter of readings within positions ({ $test }, p = { $p })
   *[no] the mean residuals of positions agree with the scatter of readings within positions ({ $test }, p = { $p })
}
less-than-the-scatter = the { $by_position ->
    [yes] mean residuals of positions are smaller than the scatter of readings within positions allows
   *[no] residuals are smaller than the scatter of replicates allows
} ({ $test }, probability of a smaller F: { $p }): that scatter contains an effect that cancels in { $by_position ->
    [yes] the mean of a position, such as one proportional to the rate, or a drift
   *[no] the mean of replicates, such as a drift or an input that the model does not read
}
diagnose-says-what-is-missing = run `tumble diagnose` on this campaign to find what the model lacks
residuals-of-have-too-runs-of-one = residuals of { $sensor } have too { $few ->
    [yes] few
   *[no] many
} runs of equal sign ({ $runs }; expected { $expected }; p = { $p }): check for { $few ->
    [yes] drift
   *[no] alternating errors
}
prior-contradicts-the-readings = the prior of { $id } contradicts the readings: they differ by { $w } standard uncertainties (p = { $p })
residuals-follow-a-column = residuals of { $sensor } depend on { $column }: sorted by it, they have too few runs of equal sign ({ $runs }; expected { $expected }; p = { $p })
residuals-are-not-normal-shapiro-francia-w = residuals are not normal (Shapiro-Francia W' = { $w }, p = { $p })
lack-of-fit-over-an-input = LACK OF FIT over { $input }: in eighths of its range the mean residuals of { $sensor } differ from zero by more than noise explains (chi-square { $chi_square } with { $dof } degrees of freedom, p = { $p })
lack-of-fit-or-correlation = a lack of fit of { $sensor } over { $inputs } cannot be distinguished from correlated noise: state the correlation of the noise first
means-of-rows-scatter = { $much ->
    [yes] residuals of { $sensor } are NOT INDEPENDENT: the standard deviation of means of { $rows } rows is { $ratio } times that of independent rows (p = { $p }), so u is too small by about this factor; describe the correlation of the noise in "scatter" ("over" a column of times)
   *[no] the standard deviation of means of { $rows } residuals of { $sensor } is { $ratio } times that of independent rows (p = { $p }): neighbouring residuals are negatively correlated, or the stated uncertainties are too large
}
residuals-are-correlated = residuals of { $sensor } are correlated: { $correlation } at { $rows } rows (p = { $p } for all lags)
row-is-far-from-the-model = SUSPICIOUS: row { $row } of { $sensor } differs from the model by { $residual } (w = { $w }; p = { $p }, corrected for the number of rows)
suspicious-reading-of-is-off-what-the = SUSPICIOUS: reading { $index } of { $sensor } differs by { $shift } from its prediction from the other readings (w = { $w }; p = { $p }, corrected for { $tested } readings)
more-suspicious-readings = { $more } more suspicious readings: see the page or the JSON report

# report/fit_constraints.rs
no-values-meet-constraints-together-none-was = constraints { $named } contradict each other: no constraint was applied
the-constraints-were-not-applied-the-readings = the constraints were not applied: not all parameters are estimable, or the solver did not converge
constraint-costs-in-chi-square = constraint { $index } ({ $text }) increases chi-square by { $cost }
rejected-the-readings-contradict-the-bounds-p = { $bounds ->
    [yes] REJECTED: the readings contradict the bounds
   *[no] REJECTED: the readings contradict the equalities
} (p = { $p })
no-bound-is-active-the-estimate-is = { $equations ->
    [yes] no bound is active
   *[no] no bound is active: the estimate is the unconstrained one
}
equations-cost-in-chi-square = { $n ->
    [one] the equality increases chi-square by { $cost }
   *[other] { $n } equalities increase chi-square by { $cost }
}{ $tested ->
    [yes] { "" } (p = { $p })
   *[no] { "" }
}

# report/monte_carlo.rs
the-first-order-does-not-describe-its = first-order propagation is not adequate for { $id }: the limits of its { $level } % interval differ by up to { $sd } u; use the Monte Carlo interval
bounds-held-trials-back = bounds hold trials back: drawn is the constrained estimate, while u and the first-order intervals are those of the estimate without bounds; they are not compared

# fit/remarks.rs
times-go-back = { $count ->
    [one] { $name } goes back once, at reading { $reading } ({ $time }), and increases otherwise: check this time
   *[other] { $name } goes back { $count } times, first at reading { $reading } ({ $time }), and increases otherwise: check these times
}
positions-without-a-reading = { $count ->
    [one] one reading has no value of any sensor, and is left out ({ $first })
   *[other] { $count } readings have no value of any sensor, and are left out (the first: { $first })
}
all-values-of-lie-within-degrees-and = all values of { $name } are within 6.3 deg, and as radians they would cover the full circle: check the unit
rates-outside-those-of-the-table = { $name } = { $rate } deg/s: the rates of this table are { $least } to { $most } deg/s; check for rad/s or another unit
rates-would-be-round-as-radians = all values of { $name } are within 6.3 deg/s, and as rad/s they would be multiples of 5 deg/s: check the unit
tilt-is-no-small-rotation = the tilt { $id } = { $tilt } deg is not a small tilt: with { $factor } as known, the readings of { $sensor } are wrong by orders of magnitude; check their unit ({ $unit }) and { $factor }
factor-is-thousands-off-its-start = { $id } is { $ratio } times its start, and most of the readings depend on it: check that the readings of { $sensor } are in { $unit }
every-reading-of-a-channel-is-the-same = every reading of { $sensor } is { $value } although its inputs change: the channel is stuck, or its resolution is too coarse
readings-repeat-others = readings { $again } repeat readings { $first } digit for digit, though other readings at one setting differ: if they were entered more than once, u is too small
every-row-stands-there-several-times = every row occurs { $times } times with identical digits: if rows were entered more than once, u is too small by the square root of that number
condition-the-readings-hardly-tell-some-parameters = condition { $condition }: some parameters are nearly confounded; check the units of the inputs and the correlations
belongs-to-the-bench-and-stays-there = { $others } { $n ->
    [one] belongs to the bench, not to the unit
   *[other] belong to the bench, not to the unit
}.

# campaign/identity.rs
identity-unit = Unit
identity-place = Place
identity-operator = Operator
identity-instrument = Instrument
identity-valid-to = valid to
identity-traceable-to = traceable to
identity-procedure = Procedure
identity-environment = Environment
instrument-no-longer-valid = the calibration of { $name } was valid to { $valid_to }, before the measurement on { $date }
interval-sums-over-the-likelihood-of-the-variances = the readings determine some variances poorly: intervals are averaged over all variances and correlation times, weighted by their likelihood
scale-factor-errors-need-readings = nonlinearity, asymmetry, hysteresis and repeatability of scale factors are not computed for a streamed record: reduce it to readings first (tumble reduce)
scale-factor-error-has-limits = { $id } has limits, but these readings do not determine it: at least three rates about the input axis of the sensor are needed; asymmetry also needs both senses, hysteresis both directions of approach, and repeatability several runs

# sources of scatter
scatter-largest-share = largest share
source-readings-of = readings of { $sensor }
source-priors = priors
source-per = { $of } per { $per }
source-over-per = { $of } over { $over } per { $per }
campaign = campaign
source-note-sentence = `{ $source }`: { $note }.

# words of several reports
correction-error-in = { $error } { $unit } in { $id }
from-to = { $a } to { $b }
conformity-is = Conformity: { $outcome } ({ $rule }).
note = Note
tone-good = OK
tone-caution = Caution
tone-bad = Problem

# the certificate
robust-estimator = Robust estimator: { $method }.
dcc-covariance = Covariance of the estimates
dcc-relates-only-to-the-items = The results relate only to the items calibrated.
dcc-traceable = The results are metrologically traceable, by { $by }, to { $to }.
calibration-certificate = calibration certificate
dcc-method = Least-squares adjustment of a multi-position test
dcc-uncertainty = Expanded uncertainties: standard uncertainties multiplied by the coverage factor that is given with them
dcc-not-stated = not stated

# why Gauss-Newton ended
stop-settled = converged: the last step is negligible
stop-unsettled = the scale factors of the weights did not converge in the last step
stop-limit = the limit of the number of steps was reached
stop-stalled = the steps remain large although the fit no longer improves: the readings determine some combination of parameters poorly
stop-no-descent = no fraction of the last step improves the fit
stop-less-likely = the readings are far less likely at the solution than at the reference point, because what scatters follows the estimates; state starting values
stop-out-of-range = numerical overflow after the last step

# report/changes.rs
before = before
after = after
difference = difference
per-day = per day
f-test = { $is_of ->
    [yes] { $sensor }: F
   *[no] F
} = { $f } with { $between_dof } and { $pure_error_dof } degrees of freedom
chi-square-with-degrees-of-freedom = chi-square { $statistic } with { $dof } degrees of freedom
all-parameters-together-p = { $changed ->
    [yes] All parameters together: { $test }, p = { $p }: the unit has changed.
   *[no] All parameters together: { $test }, p = { $p }: no significant change.
}
birge-ratio = Birge ratio
changes-only = only { $which }: { $ids }
date = date
serial = serial number
last = last
per-year = per year

# report/html/changes_page.rs
two-calibrations-of-one-unit = Two calibrations of one unit
changed-by-more-than-the-uncertainties-allow = Changed by more than the uncertainties allow: { $ids }.
beyond-u-but-not-together = Changed by more than the expanded uncertainty (|E_n| > 1), but not significant with { $tested } quantities tested together: { $ids }.
shared-by-both-calibrations-and-therefore-not = Inputs common to both calibrations, not counted twice: { $shared }.
u-expanded-uncertainty-of-the-difference-e-2 = U: expanded uncertainty of the difference; E_n = difference/U. Marked: significant with all quantities tested together (Holm).
differences-of-the-two-calibrations-over-their = Differences of the two calibrations divided by their expanded uncertainties: a bar that excludes zero is a change.
the-weighted-mean-of-both-its-u = The weighted mean of both; its u is valid if the two agree, that is, if the Birge ratio is not well above 1.
history-of-calibrations = History of { $calibrations } calibrations
drift-beyond-the-scatter-of-the-calibrations = Drift beyond the scatter of the calibrations: { $drifts }.
leaves-its-limits = { $past ->
    [yes] `{ $id }` left its limits about { $day }.
   *[no] `{ $id }` leaves its limits about { $day }.
}
over-time = over time
bars-limits-and-trend = Bars: 2 u. Dashed: limits. Line: trend, where it is significant.

# report/plot/history.rs
year = year

# compare/misprints.rs
the-tables-own-readings-give-another-value = the readings of the table give a different value
printed-with-the-opposite-sign = { $off ->
    [yes] printed with the opposite sign to the table and the formulas, and off in the last digit
   *[no] printed with the opposite sign to the table and the formulas
}
this-is-the-value-of-group-not = this is the value of group { $value }, not the mean
not-the-mean-of-the-table = not the mean of the table
mean-of = mean of { $id }
in-the-printed-equation = { $id } in the printed equation
the-printed-equation-has-the-printed-chain = { $id } is in the printed equation, but not in the printed chain of rotations
coefficient-of-in-the-printed-equation = coefficient of { $id } in the printed equation
the-chain-of-rotations-gives-the-opposite = the chain of rotations gives the opposite sign
the-chain-of-rotations-gives-another-value = the chain of rotations gives a different value
reports-are-of-two-units = the reports are of different units, { $first } and { $second }: the differences are not changes of one unit
first-report-is-the-later-one = the first report ({ $first }) is later than the second ({ $second }): before and after are exchanged
quantity-at = { $id } at { $value }

# fit/azimuth.rs
azimuth-is-any = both components may be zero, so every direction is possible: the interval is the full circle, and u is that of a uniformly distributed angle
azimuth-interval = { $bounded ->
    [yes] { $level } % interval { $low } to { $high }{ $unit }: it and U are those of the unconstrained estimate, truncated at the bounds
   *[no] { $level } % interval { $low } to { $high }{ $unit }: the components are near zero, so it is not estimate - U to estimate + U
}

# fit/scale_factor.rs
largest-of-alike = the largest of { $of } deviations; within the noise, any of { $alike } may be the largest, so k is that of the maximum of { $alike }
scatter-of-runs = standard deviation of the slopes of { $runs } runs, which includes the noise of their readings

# correction
left-out-not-estimable = not estimable: { $names }
its-line-does-not-bind = its equation does not depend on an input
its-line-has-no-slope-at-zero-input = its line has no slope at zero input
its-line-follows-no-rate = its model line does not depend on a rate or a specific force to first order (for a bench without a chain, "in_use" states which columns are rates and specific forces)
its-norm-is-of-no-triad = its line is the norm of a vector that is not an affine function of as many readings, or its unit is not one of rate or specific force
dcc-as-found = as found, before adjustment
dcc-as-left = as left, after adjustment
dcc-correction = First-order correction: inputs = matrix * (readings - bias); frame of the inputs: { $frame }.
dcc-row = Row of the matrix for { $input }
angles-at-bounds = Vertical lines: active bounds; there the bar is the interval truncated at the bounds.
source-weights = estimated weights (Kenward-Roger)

# report/diagnose/words.rs
effects-are-missing = { $n ->
    [one] one effect is missing from the model: { $names }
   *[other] { $n } effects are missing from the model: { $names }
}
what-remains-is-more-than-noise = { $found }; { $more ->
    [yes] the remaining residuals exceed the noise
   *[no] the remaining residuals are no larger than the noise, but follow a pattern
}, and no further effect is probable
effects-are-suspected = { $more ->
    [yes] the residuals exceed the noise
   *[no] the residuals are no larger than the noise, but follow a pattern
}; suspected, but not probable enough to be named, or not significantly different from zero: { $suspected }
and-further-effects-are-suspected = { $found }; also suspected: { $suspected }
effect-with-probability = { $name }, probability { $p }
nothing-is-missing = { $noise ->
    [known] nothing is missing: the residuals are no larger than the noise
    [scatter] no effect is significant; the variances of the random effects are estimated from these readings, so completeness cannot be tested
   *[residuals] no effect is significant; the noise is estimated from the residuals, so completeness cannot be tested
}
nothing-is-probable = the residuals exceed the noise (p = { $p }), but no effect is probable enough to be suspected: whether an effect is missing cannot be decided
unexplained = { $more ->
    [yes] the residuals exceed the noise
   *[no] the residuals are no larger than the noise, but follow a pattern
}, and no effect or set of effects that was tried is a probable explanation
not-diagnosable = { $of ->
    [mission] nothing can be diagnosed: fewer than three values were measured
   *[campaign] nothing can be diagnosed: there are as many readings as unknowns, so no residuals remain
}
effect-named = { $name } (`{ $regressor }`)
effect-in-sensors = { $name } in { $sensors }
effect-or-others = { $n ->
    [one] { $name }, or one other effect that this schedule cannot distinguish from it
   *[other] { $name }, or one of { $n } other effects that this schedule cannot distinguish from it
}
readings-were-averaged = ; { $from } readings were averaged to { $groups }, each of one setting over one interval of time
candidates-tried = { $candidates } candidates tried, { $distinct } of them distinct in these data; every p is corrected for their number; significance { $significance }{ $averaged }
columns-not-tried = { $n ->
    [one] the column { $columns } was not tried, since its title is no name of the model line's algebra
   *[other] the columns { $columns } were not tried, since their titles are no names of the model line's algebra
}; `columns` of the campaign can give a title a name
one-further-reading-would-help = one further reading makes a diagnosis possible; best positions: { $positions }
diagnosis-of = { $title }: diagnosis
explains-beyond-the-others = explains: share of the residual sum of squares, in addition to the other effects.
noise-from = { $from ->
    [stated] as stated
    [replicates] from replicates
   *[residuals] estimated from the residuals of the final model; there is no independent estimate, so lack of fit cannot be tested
}
error-of = error of { $id }
error-of-the-prior-of = error of the prior of { $id }
it-misses-by = error of the constraint
against-its-stated-uncertainty = { $within ->
    [yes] this is { $times } times its stated standard uncertainty: consistent, but the readings determine it more precisely; estimate it with the stated value as a prior
   *[no] this is { $times } times its stated standard uncertainty: the stated value is wrong
}
is-now-estimated = { $was ->
    [known] { $id } is estimated, no longer taken as known
    [prior] { $id } is estimated without its prior
   *[tilt] { $id } is estimated, no longer taken as zero
}
constraint-is-taken-away = constraint { $number } is removed
together-with = with { $other }
discriminates = { $at } (discriminates { $n } of { $of })
the-model-has-all-but = { $share } of it is not absorbed by the model
of-its-full-size = { $share } of its full size
u-after-includes = { $what ->
    [both] The u after the repair includes the spread of the estimates over the aliases, weighted by their probabilities, and the unexplained residuals; shift/u uses u without these.
    [aliases] The u after the repair includes the spread of the estimates over the aliases, weighted by their probabilities; shift/u uses u without it.
   *[remainder] The u after the repair includes the unexplained residuals; shift/u uses u without them.
}
what-is-unexplained-follows = the unexplained residuals follow { $name }
what-is-unexplained-differs = the unexplained residuals differ from reading to reading
with-a-standard-deviation-of = { $follows }, with a standard deviation of { $sd } { $unit }
probability-of-it-or-an-alias = { $p } that it or an alias is present, { $named } as named
fit-takes-the-effect-as-named = fit of this campaign assumes the effect as named ({ $named }); if it were one of its aliases, the estimates would change, most of all { $id } by { $by } { $unit } (u = { $u } as named); u_after of the diagnosis includes this
constraint-state = constraint { $index }, { $text }: { $state }
holdout = { $n ->
    [one] leave-one-out check: { $n } position was predicted from a fit of the others; difference from the prediction: { $before } standard uncertainties (1 is expected)
   *[other] leave-one-out check: each of { $n } positions was predicted from a fit of the others; rms difference from the predictions: { $before } standard uncertainties (1 is expected)
}{ $found ->
    [yes] , { $after } with the effects found
   *[no] { "" }
}{ $skipped ->
    [0] { "" }
    [one] ; { $skipped } cannot be left out, because it alone determines a parameter
   *[other] ; { $skipped } cannot be left out, because each alone determines a parameter
}
further-sensors-are-not-drawn = { $n ->
    [one] { $n } further sensor is not drawn.
   *[other] { $n } further sensors are not drawn.
}
setting = setting
rows-of = { $n } rows of { $motion }
in-the-mission = In the mission
refits = The refit did not converge after { $times } runs of the full simulation.
the-gap-by-channel = Residuals by channel
navigation-errors = Navigation errors
count-device = { $n ->
    [one] { $n } device
   *[other] { $n } devices
}
wrote = wrote { $file }
note-nothing-found = { $what ->
    [error] note: no error was found, so no mission is written
   *[effect] note: no effect was found, so no repaired model is written
}

# report/diagnose/table.rs
and-more = { $shown } and { $more } more
chi-square = chi-square
residual-sd = residual sd
max = max
noise-floor = noise floor: { $noise }
as-given = as given
nearest-of-the-catalogue-would-take-off = Best combination of the catalogue: { $names } would explain { $share } %; not named, because it is not probable enough or not significantly different from zero.
shift-u = shift/u

# report/html/diagnose_page.rs
what-is-missing = What is missing
unknown = unknown
noise-sd = noise sd
explains = explains
fits-not-significantly-worse = Fits not significantly worse
only-through-small-terms = Aliases through tilt-dependent terms only
no-position-of-this-bench-tells-it = No position in steps of 45 deg at the rates of this schedule distinguishes it from
to-confirm = To confirm
with-what-was-found = with the effects found
the-pattern = The pattern
mean-residual-at-each-state-of-the = Mean residuals at each state of the joints, most significant first; z: in standard deviations.
marked-shifts-of-more-than-twice-their = Marked: shifts of more than twice their standard uncertainty.
what-it-does-to-the-estimates = Effect on the estimates
where-the-gap-is = Where the residuals are
means-of-the-residuals-with-the-model = Mean residuals of the model as given, for each level of each setting; z: in standard deviations.
in-the-model = in the model
strongest-further-candidate = strongest further candidate
p-of-what-is-left = p of the remaining residuals
the-gap = Residuals step by step
taken-as-known = Taken as known: { $known }.
priors-entered-as-rows-of-their-own = Priors entered as additional rows: { $priors }.
gauss-newton-does-not-converge-here-so = Gauss-Newton does not converge here, so the linear estimator was diagnosed.

# report/html/diagnose_figure.rs
each-reading-minus-the-model = { $found ->
    [yes] Residuals: circles for the model as given, discs for the model with the effects found.
   *[no] Residuals of the model as given.
}
readings-are-grouped-by-which-the-gap = Readings are grouped by { $factor }, which explains most of the residuals; a bar is the mean residual of a group with the model as given.
one-reading-in-is-drawn = One reading in { $every } is drawn, and all outliers.

# report/plot/gap.rs
readings-in-their-order = readings in their order
readings-near-number = readings near no. { $number }
noise-standard-deviations = noise, ±2 standard deviations

# report/batch.rs
reasons = Reasons
devices-tested = tested
expected-by-chance = expected by chance
beyond-chance = beyond chance
chance-alone-finds = A device may have several reasons. Expected by chance: rejections by the test at { $level } if nothing is wrong. Beyond chance: rejections that remain at { $level } for all devices together.
observed-sd = observed sd
sd-of-devices = sd of devices
verdict = verdict
limits = limits

# report/html/batch_page.rs
all-are-accepted = All { $devices } are accepted.
accepted-devices-are-noisy = { $n ->
    [one] The residuals of an accepted device scatter more than those of the others: { $names }.
   *[other] The residuals of { $n } accepted devices scatter more than those of the others: { $names }.
}
sd-of-the-others = sd of the others
noisy-devices-f = Residuals that scatter more than those of the others: F = (residual sd / pooled sd of the devices with less scatter)^2, p for this device alone; listed if significant at 1 % over all devices (Cochran's test of the largest variance, ISO 5725-2), noisiest first, at most 50. Check the readings, the channel and the cables of this device.
of-are-not-accepted-rejected-a-rank = { $bad ->
    [one] { $bad } of { $devices } is not accepted
   *[other] { $bad } of { $devices } are not accepted
}: { $rejected } rejected (a rank defect, a failed global test, lack of fit, no convergence), { $malformed } malformed (readings that do not match this campaign).
conformity-rule-pass-undecided-fail = Conformity (rule `{ $decision }`): { $pass } pass, { $undecided } undecided, { $fail } fail.
devices-differ-by-more-than-their-readings = Quantities in which devices differ by more than the scatter of their readings (p < 0.01): { $names }.
devices = devices
p-if-alike = p if alike
min = min
accepted-devices-only-sd-between-devices-u = Accepted devices only; mean and standard deviation exclude outliers. observed sd: standard deviation of the estimates of all devices; u: root mean square of the devices' standard uncertainties; sd of devices: the part of it that the scatter of their readings does not explain; p if alike: probability of such a standard deviation if all devices were alike (F, or chi-square where uncertainties are stated).
distributions = Distributions
each-histogram-shows-the-accepted-devices-the = Each histogram shows the accepted devices; the curve is expected from the scatter of the readings alone; dashed lines are limits. Outlying values are counted in the first and the last bar.
devices-that-are-not-in-order = Devices with problems
devices-that-stand-apart = Outlying devices
no-accepted-device-stands-apart-from-the = No accepted device is an outlier in a quantity at 1 % over all devices and quantities.
z-value-median-mad-beyond-what-a = z = (value - median) / (1.4826 MAD), beyond the limit of a normal distribution at 1 % over all devices and quantities; largest first, at most 50.
control-charts = Control charts
lots-beyond-their-control-limits = Means of lots beyond their control limits: { $lots }.
points-are-means-of-lots-the-line = Points are means of lots, the line is the mean of the accepted devices without outliers, dashed lines are three standard deviations of a lot's mean from the scatter within lots; triangles are means beyond them.

# report/navigate_diagnose_table.rs
rows-of-other-scenarios-left-out = ; { $rows } rows of other scenarios left out
motion = motion
time = time
outliers = outliers
these-data-cannot-show = Not observable in these data: { $sources }.
absurd = (implausible size)
rms = rms

# report/html/navigate_diagnose.rs
measured-navigation-errors = Measured
values-are-changes-of-the-missions-errors = Values are changes relative to the errors in the mission.
gap-in-standard-uncertainties = Residuals, measured minus predicted, in standard uncertainties
channel = channel
values = values
gap-of = Residuals of `{ $name }`{ $where_ }: root mean square { $size }
what-is-left-of-with-two-standard = Remaining residuals of `{ $name }`{ $where_ }, with two standard uncertainties
discriminated-by = Discriminated by
effect = effect

# cli
error-what = error: { $text }
error-expected = expected { $text }
error-option = option { $text }
error-found = found { $text }
error-in = in { $file }
error-line = , line { $line }
error-column = , column { $column }
error-at = at { $path }

# plan, foresight, navigate, reduce, noise
uncertainty-depends-on-a-value = the uncertainty of { $untold } depends on the value of { $needs }, which is not stated: at zero the dependence vanishes; state it with --at { $first }=VALUE or a "start"
values-checked-by-no-other = values without redundancy: { $n }
bounds-not-counted = { $n ->
    [one] { $n } bound is not taken into account: a bound lowers an uncertainty only where it is active
   *[other] { $n } bounds are not taken into account: a bound lowers an uncertainty only where it is active
}
is-not-estimable = { $text } is not estimable
u-at-equal-effort = { $cost ->
    [yes] at equal cost
   *[no] at equal readings
}
cannot-be-determined-by-any-choice = { $text } cannot be determined by any choice of these candidates
to-run-in-this-order = To run, in this order
fewer-readings-cannot-reach-it = ; fewer readings cannot reach it
shows-from = detectable from
and-shifts = shift of a parameter
plan-rank = rank { $rank }, { $dof }
combinations-cannot-be-estimated = Combinations of parameters that cannot be estimated: { $n }.
to-s = to, s
tilt = tilt
carried-by = by
none-at-the-equator = none (at the equator)
schuler-earth-foucault = Schuler { $schuler } min, Earth { $earth } h, Foucault { $foucault }

# report/noise_table.rs
record-changes = the record is not noise alone: at { $at } s its mean over { $tau } s changes by { $by } { $unit }, { $in_sd } standard deviations of this noise; check that the sensor was at rest, or cut the record there
their-sum-describes = { $well ->
    [yes] Their sum describes the deviations
   *[no] Their sum does not describe the deviations; u and the limits allow for that
}
no-coefficients = { $why ->
    [constant] No coefficients: all samples are equal
    [short] No coefficients: fewer than five octaves of averaging times, which need 80 samples with at most a tenth of them missing
   *[undescribed] No coefficients: no sum of the terms describes these deviations
}
described-from = Averaging times below { $from } s are not used: there the record shows a filter of the sensor, or held or quantized samples, which these terms do not describe
samples-left-out = Samples treated as missing: { $events }
random-walk-sampled = The rate random walk is modelled as sampled at the end of each interval of { $interval } s, not as averaged over it: this describes the deviations better
samples-mean = { $stretches ->
    [one] { $samples } samples, mean { $mean } { $unit }.
   *[other] { $samples } samples in { $stretches } stretches, mean { $mean } { $unit }.
}
allan = Allan
edf = edf
hadamard = Hadamard
modified = modified

# report/html/noise_page.rs
noise-of-a-record = Noise of a record
sampling-rate = Sampling rate
overlapping-allan-deviation-of-samples-with-its = Overlapping Allan deviation of { $samples } samples with its { $level } % chi-square intervals, and the fitted coefficients as a line.
allan-deviation = Allan deviation, { $unit }

# report/reduction_table.rs
segments-begin-and-end-with-blocks-of = Segments begin and end with blocks of { $block } samples.
column-of-set-values = { $column } is constant within every segment, as a set value is: its samples show neither noise nor resolution. { $assumed ->
    [yes] The resolution is assumed to be { $step }, the last decimal place; u is the uncertainty of rounding to it.
   *[no] Its digits show no resolution, so u is zero.
}
noisier-segments = { $count ->
    [one] { $column } in segment { $segment } scatters { $times } times as much as elsewhere: its u is based on the noise of this segment.
   *[other] { $column } scatters more in { $count } segments than in the others, { $times } times as much in segment { $segment }: their u is based on the noise of these and similar segments.
}
from-s = from, s
reason = reason
white = white
autocorr = autocorr
n-eff = n_eff
lag = lag 1
slope-p = slope p

# report/html/reduction_page.rs
from-samples-to-readings = From samples to readings
samples = Samples
segments = Segments
not-used-of-means-have-a-slope = Segments used: { $segments }; not used: { $stretches }. Means with a significant slope (p < 0.01): { $sloping } of { $all }. Anomalous samples in segments, included in the means: { $odd }.
the-whole-record-segments-are-shaded = The whole record; segments are shaded.
record = Record
u-on-either-side-of-a-mean = The mean +- 1.96 `u` has a coverage of 95 % if the noise is faster than the segment: slower noise is not in `u`. `u` is estimated from all segments of a column with the same noise together, and includes the uncertainty of this estimate. For comparison: u for white noise, with the sum of the autocorrelations, and as the Allan deviation at the segment's length.
column = column
odd = anomalies
not-used-2 = Not used

# report/navigate_table.rs
h-in-steps-of-s = { $duration } h in steps of { $step } s
duration = Duration
vertical-channel = Vertical channel
scenario = scenario
perfect-unit-a-perfect-unit-the-navigators = `perfect_unit`: a unit without errors, that is, the error of the navigator itself.
azimuth = azimuth
velocity = velocity
what-the-calibrations-uncertainty-does = Effect of the calibration's uncertainty
linear-covariance = linear covariance
monte-carlo-draws = Monte Carlo, { $draws } draws

# report/html/navigate.rs
convention = Convention
periods = Periods
root-mean-square-errors = Root mean square errors
against-the-first-motion = Relative to the first motion
at-most-at-the-end = { $label }: at most { $most }, { $last } at the end
curve-of = Error of { $of }: { $what }
after-h-the-position-is-off-by = { $motion }: after { $time } h the position error is { $position } m (rms { $position_rms } m), the azimuth error { $azimuth } arcsec (rms { $azimuth_rms } arcsec)
with-most-of-it-from-position-rms = { $text }, in scenario `{ $scenario }`; mainly from { $sources } (position, rms)
position-at-the-end-m = position at the end (m)
ratios-of-root-mean-squares-where-the = Ratios of root mean squares; - where the error in the first motion is no larger than that of the navigator itself.

# report/plan_table.rs
every-remounting-scatters-sd-rad-for-a = random change of { $id } at every remounting: sd { $sd } (rad for a tilt)
zero-no-parameter-has-a-start-prior = zero (no parameter has a start, prior or --at)
plan-table-others = { $count } others = 0
in-with-cost = { $readings }; mountings: { $mountings }, rate changes: { $rate_changes }, cost: { $cost }
needs-a-value = needs a value
largest-near-the-reference = largest near the reference
strongest-correlation = strongest correlation
undetected-fault = effect of an undetected error
so-many-values-what-a-diagnosis-could = too many values: detectable effects are not predicted, and the values are not listed
uncertainty-through-tilts = { $counted ->
    [yes] included above: with tilts of { $tilts } arcsec, the uncertainty of { $known } adds { $u }{ $unit } to { $parameter }
   *[no] not included: the uncertainty of { $known } acts through the tilts, whose size is unknown before the measurement; tilts of { $tilts } arcsec would add { $u }{ $unit } to { $parameter } (--tilts { $tilts } includes it)
}
best-of-all-choices = the best of all { $all } admissible choices of these candidates (proven 100 %)
proven-efficiency = at least { $share } as good as the best admissible choice of these candidates (proven)
the-bound-allows-more-mountings-than-the = the bound assumes more mountings than the cost allows, so the choice may be the best
so-few-portions-cannot-follow-the-best = with so few portions the optimal weights are approximated only roughly; use more or smaller portions
the-bound-itself-may-be-too-high = the bound itself may be { $gap } too high
no-angle-is-worth-moving = moving angles between the candidates does not improve the schedule, in steps down to { $resolution } deg
angles-moved = { $finished ->
    [yes] mountings with angles moved off the candidates, in steps down to { $resolution } deg: { $mountings }; the schedule is { $gain } % better
   *[no] mountings with angles moved off the candidates, in steps down to { $resolution } deg (search stopped at its limit): { $mountings }; the schedule is { $gain } % better
}
cost-limit-of-the-search = { $budget ->
    [yes] cost limit of the search: { $cost }
   *[no] cost limit of the search: { $cost } (cost of the given schedule, in proportion for more readings; --any-cost: no limit)
}
without-it-nothing-determines = without it { $parameter } is not estimable
without-it-u-of-grows-by = without it u of { $parameter } grows by { $share } %
u-of-their-coefficients-and = u of their coefficients { $p } and { $q }
and-both-in-the-model-before = { $a } and { $b }, both in the model: before, { $before }
with-the-added-positions = with the added positions, { $after }
planned-with-columns = new positions are planned with { $held }, as in the schedule's last reading; enter the actual values when they are measured, or give other candidates with --candidates FILE
positions-share-deviations-planned-for = readings have random effects in common ({ $line }); the chosen positions are planned for { $levels } (a sweep uses the value of the schedule's last reading; --candidates FILE gives others)
no-candidate-would-separate-it-but-all = no candidate would separate them; all candidates have { $held } (--candidates FILE gives others)
of-is-found-with-probability-where-the = { $effect } of { $size } is detected with probability { $power } where the u of its coefficient { $coefficient } is at most { $u }
the-goal-counts = { $some ->
    [yes] the goal applies to { $counted }, but not to { $derived }
   *[no] the goal applies to { $counted }
}
this-is-the-cheapest-schedule-that-was = this is the cheapest schedule that was found; that none is cheaper is not proven
leverage = leverage
no-candidate-discriminates = No candidate discriminates { $a } and { $b }, so nothing is added.
seed-of-starts-ended-here = , seed { $seed }, found by { $hits } of { $starts } starts
of-its-readings-chosen-among-candidate-portions = { $chosen } of its readings chosen among { $candidates } candidate portions, criterion { $criterion }{ $starts }
better = better
gain = gain

# report/html/plan_page.rs
judged-at-2 = Evaluated at
the-given-schedule = The given schedule
the-better-schedule-in-full = The better schedule in full
model-and-noise = Model and noise
the-better-schedule-2 = The better schedule
goal-not-determined = The goal is not reached: not every quantity of the goal is determined.
goal-reached = { $reached ->
    [yes] The goal is reached: the largest uncertainty is { $share } times its limit{ $proof }.
   *[no] The goal is not reached: at best, the largest uncertainty is { $share } times its limit.
}
still-to-run-2 = Still to run: { $work }.
predicted-standard-uncertainties = Predicted standard uncertainties
at-equal-effort = { $cost ->
    [yes] At equal cost: the given schedule repeated, or cut, to the cost of the better one.
   *[no] At equal readings: the given schedule repeated, or cut, to the readings of the better one.
}
mounting = mounting
in-this-order-a-drift-of-one = In this order, a linear drift of one noise standard deviation over the run shifts a parameter by at most { $share } of its uncertainty.
where-the-positions-lie = Where the positions lie
squares-the-schedules-positions = Squares: the schedule's positions.
dots-candidates-squares-the-given-schedule-discs = Dots: candidates. Squares: the given schedule. Discs with numbers: the better schedule and its readings at each position.
then-at-a-reading-in-its-u = change of a reading, in its u
cannot-be-distinguished-from = cannot be distinguished from
effects-that-would-show = Detectable effects, one row for each distinguishable direction
nearly-alike-cosine-beside-the-model-and = Nearly alike: cosine after projection on the model, and the smallest size at which the two can be distinguished.
taken-up-by = absorbed by
effects-that-never-show-estimated-parameters-take = Effects that cannot be detected: the estimated parameters absorb them and are biased
zero-at-every-position = Zero at every position: { $effects }
not-tried-without-a-column-kinds-of-2 = Kinds of effect not tried, because there is no column `{ $column }`: { $families }
effects-of-the-catalogue-were-tried-in = { $tried } effects of the catalogue, { $distinct } distinct directions after projection on the model.
what-a-diagnosis-could-find = What a diagnosis could detect
not-every-unknown-has-a-predicted-uncertainty = Not every parameter has a predicted uncertainty at the point of evaluation.
every-unknown-can-be-estimated = Every parameter can be estimated.
each-value-leverage-minimal-detectable-bias-and = Each value: leverage, minimal detectable bias (MDB; 0.1 %, 80 %), and the largest change of an angle by an undetected error

# report/plot/deviations.rs
averaging-time-s = averaging time, s

# report/plot/record.rs
time-since-the-first-sample-s = time since the first sample, s

# report/plot/positions.rs
deg-across-deg-up = { $across } (deg) across, { $up } (deg) up

# report/foresight.rs
regressor-of-sensor = { $regressor } of { $sensor }
foresight-nearly = nearly { $regressor } ({ $cosine })
apart-from = { $regressor } (cosine { $cosine }; distinguishable if larger than { $apart })
none-would-show-the-estimated-parameters-take = none would be detectable: the estimated parameters absorb every effect that these positions excite
smallest-size-that-shows-u-significance-for = smallest detectable size: { $size } u (significance { $significance } over all directions, power { $power }); if the noise is known from the residuals only: { $with_residuals }
grouped-by = { $what } by { $by }
gauss-newton-did-not-converge-after = Gauss-Newton did not converge after { $steps }: { $stop }.
reduction-segment = Segment { $segment }: { $notes }.
terms = Terms
meaning = meaning
lot = lot
control-limits = control limits
plan-of = Plan: { $title }
more-rows = { $option ->
    [yes] ... and { $n } more rows (all with -v)
   *[no] ... and { $n } more rows
}
nearly-alike = nearly alike
iterations = Iterations
weighted-sum-of-squares = weighted sum of squares
step-of-the-predictions = change of the predictions (norm)
share-of-the-step = share of the step

# cli/guide/view.rs
guide-position = position { $label }: { $setting }
guide-newest = reading { $reading }, { $place }: { $agreement ->
    [agrees] agrees ({ $sd } sd)
    [disagrees] DOES NOT AGREE ({ $sd } sd)
   *[not-predicted] not yet predicted by the others
}
guide-time-goes-back = time_s goes back from { $before } to { $now }
guide-likely = { "  " }likely: { $kind }
guide-not-told = { "  " }the cause cannot be identified yet:
guide-undo = { "  " }{ $culprit ->
    [yes] reading { $reading } is probably wrong ({ $probability }): 'undo { $reading }' removes it
   *[no] 'undo' removes the last reading, 'undo N' reading N
}; a reading that is not removed is used in all results
guide-explanation = { "    " }{ $probability }  reading { $reading }, { $kind }: { $what }
guide-goal-open = { "  " }{ $id }: not estimable yet, goal { $goal } { $unit }
guide-goal = { "  " }{ $id } = { $value } { $unit }, u = { $u }, goal { $goal }: { $met ->
    [yes] met
   *[no] not yet
}
guide-diagnosis = { "  " }diagnosis: { $verdict }
guide-effect = { "    " }{ $name } ({ $terms }){ $size }, probability { $probability }
guide-nothing-missing = { "  " }probability that no effect is missing or all are named: { $probability }; effects not yet observable: { $unseen }
guide-unreachable = { "  " }{ $id }: its goal cannot be reached with these positions
guide-next = next: { $place } ({ $why ->
    [information] expected information { $nats } nats, cost { $cost }
    [tells-apart] discriminates { $between }
   *[again] the same position again
})
guide-moving = the bench moves
guide-held = { $place }: held for { $seconds } s
guide-held-mean = , { $sensor } u = { $u } { $unit } (required { $wanted })
guide-held-wait = { $place }: held for { $seconds } s{ $means }; hold it { $wait } s longer
guide-held-never = { $place }: held for { $seconds } s{ $means }; the required u cannot be reached by holding; 'take' accepts the mean so far
guide-read = { $place }: read; set the next position
guide-left = { $place }: LEFT after { $seconds } s{ $means } without a reading
guide-port-is-back = serial port { $name } is connected again
guide-which = position? Several positions agree with the reading; answer: position LABEL
  { "  " }{ $candidates }
guide-view-set = Set
guide-view-held = Held
guide-view-goals = Goals: u against the goal
guide-view-residuals = Residuals in standard deviations, by reading
guide-view-missing = What may be missing: probability
guide-ended = { $by ->
    [reached] done: every goal is met, and no effect is missing or all are named; { $readings } readings, cost { $cost }
    [nothing-to-gain] stopped: further readings at the positions of this schedule would not decide the open questions; { $readings } readings, cost { $cost }
   *[most-readings] stopped: the limit of { $readings } readings was reached (--most); cost { $cost }
}

# Run sheets and drawings of benches
run-sheet = Run sheet: { $bench }
run-sheet-how = Take the readings in this order. Write each value into its empty cell; the table of the same readings as CSV (--sheet FILE.csv), filled in, is read with --readings.
mountings = Mountings
cost = Cost
cost-so-far = cost so far
unit-at-the-start = The unit at the start of the mission: heading, pitch and roll with their amplitudes.
heading-angle = heading
pitch-angle = pitch
roll-angle = roll
bench-at-first-reading = The bench at the first reading: joints as rings about their axes, from the ground (outside) to the unit (inside), with tilts at zero. Red arcs: rotating joints.
east-axis = E
north-axis = N
up-axis = up
gravity-arrow = gravity
earth-rate-arrow = Earth rate
