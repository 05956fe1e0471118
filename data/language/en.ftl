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
count-contribution = { $n ->
    [one] { $n } contribution
   *[other] { $n } contributions
}
count-pass = { $n ->
    [one] { $n } pass
   *[other] { $n } passes
}
count-step = { $n ->
    [one] { $n } step
   *[other] { $n } steps
}
count-kind = { $n ->
    [one] { $n } kind of effect
   *[other] { $n } kinds of effect
}
degrees-of-freedom = degrees of freedom

## Closed vocabularies of the reports, as JSON has them

term-state = { $word }
term-outcome = { $word }
term-estimator = { $word }
term-distribution = { $word }
term-from = { $word }
term-constraint = { $word }
term-side = { $word }

# report/fit_table.rs
derived = derived
parameter = parameter
estimate = estimate
dof = dof
unit = unit
state = state
record-of-rows-read = record of { $rows } rows, read in { $passes }; the table of readings and the figures have { $shown } of them
rows-in-a-mean = rows in a mean
pairs-of-means = pairs
sd-over-that-of-independent-rows = sd against independent rows
lack-of-fit-over = lack of fit over
row-of-the-record = row
that-of-rounding-to-its-last-digit = from rounding to { $step } (the last digit, divided by sqrt 12); the readings do not scatter more than this
the-rounding-of-its-readings-which-show = from the rounding of the readings, which show no scatter
estimated-from-these-readings = estimated from these readings
residual-sd-of = Residual standard deviation of `{ $sensor }`: { $sd }, { $how }.
residual-sd-of-none-no-degrees-of = Residual standard deviation of `{ $sensor }`: none (no degrees of freedom), so no uncertainty can be given.
inconsistent-disagrees-with-the-other-sights-by = `{ $sensor }` is inconsistent: it disagrees with the other sights by { $mean_residual_deg } deg on average. Check for another side of the target, a wrong point, or a starting value that is too far away.
fit-table-note = note: { $remark }
correlated-inputs = correlated: { $list }
no-reading-responds-to-at-the-reference = No reading responds to { $moved } at the reference point, because every factor that multiplies it is zero there: the iteration started from a point nearby.
held-where-the-iteration-began-since-the = Held at the starting value, because the exact model determines them too weakly elsewhere: { $held }.
gauss-newton-converged-after = Gauss-Newton converged after { $steps }; the linear estimates (one step from the reference point) are the same within 0.1 u.
u-holds-only-for-as-held-another = U is valid only for `{ $held }` held at this value: a change of it by { $by } changes { $shifts }.
derived-without-a-value = derived quantities without a value, because they depend on parameters that are not estimable: { $names }
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
is-at-a-bound-interval-to-of = `{ $id }` is at a bound: { $level } interval { $low } to { $high } { $unit } (that of the free estimate, truncated at the bounds).
is-at-a-bound-and-the-whole = `{ $id }` is at a bound, and the { $level } interval of the free estimate is entirely outside the bounds: bounds and readings are inconsistent.
yes = yes
monte-carlo = Monte Carlo
mean = mean
coverage-ellipsoid-of-k-p = coverage ellipsoid of { $order }: k_p = { $k }
scale-factor-errors-are-not-drawn = not drawn: { $errors }

# report/correction.rs
the-lines-are-linear-in-the-inputs = The lines are linear in the inputs: this correction is exact.
within-the-range-of-the-calibration-it = Within the range of the calibration ({ $within }) the remaining error is at most { $errors }
below-the-standard-uncertainty-of-the-calibration = , below the standard uncertainty of the calibration everywhere there.
no-part = none
within-of-that-range-it-stays-below = ; within { $part } of that range it stays below the standard uncertainty of the calibration. Outside it, use the exact lines, as `tumble apply` does.
the-exact-lines-tumble-apply-leave-nothing = ; with the exact lines (`tumble apply`) no error remains.
correction-otherwise = { $id } (otherwise { $otherwise }{ $unit })
these-sensors-do-not-determine-give-it = These sensors do not determine { $given }: give it as a column of the record.
correction-none-of-the-sensors-follows-a = no correction: no sensor measures a rate w_* or a specific force a_* that the fit determines
input = input
bias = bias

# report/html/fit_page.rs
made-by = made by
tumble-the-same-inputs-give-the-same = tumble { $version }; the same inputs give the same bytes
sha-of = SHA-256 of { $name }
bench = Bench
source = Source
campaign = Campaign
model = Model
estimator = Estimator
residuals-and-correlations = Residuals and correlations

# report/html/fit_answer.rs
result = Result
not-everything-is-estimable-is-free-see = Not everything is estimable. The readings do not determine { $free }: see below.
global-test-chi-square-with-p = Global test: { $rejected ->
    [yes] the readings scatter more than their stated uncertainties allow: the model is incomplete, or the uncertainties are too small
   *[no] the readings scatter as their stated uncertainties say
} (chi-square { $chi_square } with { $dof }, p = { $p }).
the-readings-state-no-uncertainty-of-their = No uncertainty is stated for the readings: their standard deviation is estimated from the residuals, so these readings alone cannot test the model.
no-degrees-of-freedom-the-readings-just = No degrees of freedom: there are as many readings as parameters, so the readings cannot test the model.
one-linear-step-is-not-enough-gauss = One linear step is not enough: Gauss-Newton would go on by more than 0.1 u in { $what }. Fit without `--linear`.
from-the-fit-estimates-rank-of-freedom = From { $from } the fit estimates { $parameters } (rank { $rank }, { $dof }).
at-every-angle-is-known-to-arcsec = At { $level }, every angle is known to { $high } arcsec.
at-the-angles-are-known-to-between = At { $level }, the angles are known to between { $low } arcsec (`{ $best }`) and { $high } arcsec (`{ $worst }`).
the-scaled-design-matrix-has-condition-number = The scaled design matrix has condition number { $condition }.

# report/html/fit_correction.rs
the-correction-to-apply = The correction to apply
readings-cannot-be-corrected-not-estimable-here = Readings cannot be corrected: { $missing } { $n ->
    [one] is
   *[other] are
} not estimable here.
all-sensors-are-solved-together-for-the = All sensors are solved together for the inputs that they determine. To first order, with the numbers of this calibration:
is-left-out-of-the-correction = `{ $sensor }` is left out of the correction: { $why }.
tumble-apply-corrects-a-record-by-the = `tumble apply` corrects a record by the exact lines, `tumble export` writes them as source code; both read the JSON report of this fit.
the-rotation-from-the-sensors-axes-to = The rotation from the sensors' axes to the mounting face needs { $tilts }; { $missing } { $n ->
    [one] is
   *[other] are
} not estimable here.
direction-cosines-of-the-corrected-inputs-on = Direction cosines of the corrected inputs on the mounting face
a-corrected-input-points-along-the-sensors = Corrected inputs are components along the sensors' axes. Relative to the mounting face (the frame after the last joint) these axes are turned by { $tilts }; a rate or force known in that frame has this component along them:

# report/html/fit_estimates.rs
angle = angle
coefficient = coefficient
not-estimable = not estimable
u-combined-standard-uncertainty-k-u-expanded = u: combined standard uncertainty; { $expanded } = k u: expanded uncertainty, k from Student's t with ν effective degrees of freedom.
estimates = Estimates
not-estimable-from-these-readings = Not estimable from these readings
only-determined = only { $only } { $n ->
    [one] is
   *[other] are
} determined
the-parameters-can-move-along-and-no = The parameters can change along `{ $text }` without changing any reading; { $instead }.
determined-instead = determined instead
where-the-uncertainty-comes-from = Sources of uncertainty
source-2 = source
u-of-source = u of source
angles-in-radians-c-sensitivity-coefficient-of = Angles in radians. c: sensitivity coefficient of a single source; ν: degrees of freedom; share: part of the variance.
below-of-the-variance-left-out = { $contribution } below 0.05 % of the variance left out.

# report/html/fit_figures.rs
angles-with-their-expanded-uncertainties = Angles with their expanded uncertainties ({ $level }).
fit-figures-arcsec = { $id } { $value } +- { $expanded } arcsec
standard-uncertainties-divided-by-each-sources-share = Standard uncertainties, divided by each source's share of the variance.
u-arcsec = { $id }: u { $u } arcsec, { $bar }
standard-uncertainty = standard uncertainty
coefficients-each-sources-share-of-the-variance = Coefficients: each source's share of the variance. Sources below 0.5 % are left white.
share-of-the-variance = share of the variance
none-lies-beyond-standard-deviations = None lies beyond { $limit } standard deviations.
diamonds-lie-beyond-standard-deviations-reading = Diamonds lie beyond { $limit } standard deviations: reading { $far }.
diamonds-of-them-lie-beyond-standard-deviations = Diamonds, { $n } of them, lie beyond { $limit } standard deviations.
one-reading-in-is-drawn = One reading in { $every } is drawn.
residuals-of-figure = { $shared ->
    [yes] Residuals of { $id }, deviations that readings share taken out, before bands of two standard deviations. { $beyond }{ $thinned }
   *[no] Residuals of { $id } before bands of two standard deviations. { $beyond }{ $thinned }
}
residuals-of = Residuals of { $id }: { $beyond }
fit-figures-residual = { $id } residual
normal-plot-of-the-studentized-residuals-with = Normal plot of the studentized residuals with its pointwise 95 % band: normal residuals follow the line.
correlations-of-the-estimates-in-hundredths-blue = Correlations of the estimates, in hundredths: blue positive, orange negative, crosses where not estimable.
and-more-as-in-the-table = ; and { $lines } more, as in the table
studentized-residuals-from-to = { $n } studentized residuals, from { $low } to { $high }.
no-correlation = No correlation.
strongest-correlation-between-and = Strongest correlation: { $r } between { $a } and { $b }.

# report/html/fit_readings.rs
taken-as-zero-neither-known-nor-estimated = Taken as zero, neither known nor estimated: { $assumed_zero }.
site-latitude-earth-rate-deg-h = Site: latitude { $latitude_deg }°, Earth rate { $earth_rate_deg_h } deg/h, { $said }.
no-site-no-earth-rate-and-gravity = No site is given: the Earth rate is taken as zero, gravity as 1 g.
rows-are-exact-derivatives = { $iterated ->
    [yes] Exact: rows are exact derivatives, iterated to the solution.
   *[no] Linear: rows are exact derivatives at the reference point, and one step is taken from it.
}
uncertainties-of-the-readings-are-as-stated = Uncertainties of the readings are as stated.
errors-are-independent = { $scattering ->
    [yes] In addition to the random effects listed above, the readings of one sensor have independent errors of equal standard deviation, estimated from the residuals.
   *[no] The readings of one sensor have independent errors of equal standard deviation, estimated from the residuals.
}
entered-as-rows-of-their-own = { $prior } entered as additional rows.
known = known
exact = exact
what-was-assumed = What was assumed
detectable = detectable
redundancy-the-share-of-a-fault-that = Redundancy: the share of an error of the reading that appears in its residual. Detectable: the smallest error that a test at 0.1 % finds with a power of 80 % (MDB). Marked: studentized residual beyond { $limit }.
the-first-of-are-listed-the-json = The first { $listed } of { $n } are listed; the JSON report has all.
readings = Readings

# report/html/checks_page.rs
the-robust-estimator-did-not-settle = The robust estimator ({ $method }) did not converge.
checks = Checks
test = test
statistic = statistic
lack-of-fit = lack of fit
lack-of-fit-by-position = lack of fit by position
runs-of = runs of `{ $sensor }`
runs-expected = { $runs } runs, { $expected } expected
normality = normality
suspicious-reading = suspicious reading
shift = shift
shift-how-far-the-reading-is-off = Shift: difference between the reading and its prediction by the other readings. p: over all { $tested } readings (Sidak).
weakest-reading = weakest reading
effect = effect
change-without-suspects = change without suspects
external-reliability = External reliability
effect-what-the-smallest-detectable-fault-of = Effect: change of the parameter by the smallest detectable error of the reading.
constraints-and-weights = Constraints and weights
constraint = constraint
side = side
cost-in-chi-square = cost in chi-square
no-reading-lost-more-than-half-of = No reading has a weight below one half.
less-than-half-of-their-weight-readings = Readings with a weight below one half: { $low }.
robust-estimator-of-reweighting = Robust estimator: { $method }, { $steps } of reweighting. { $down }
checks-page-interval = interval ({ $level })
shortest = shortest
first-order = first order
of-trials-seed = { $trials } of { $asked } trials, seed { $seed }.
marked-the-first-order-is-not-good = { $trials } Marked: the interval of first order is not correct to two digits of the uncertainty.

# report/html/conformity_page.rs
conformity = Conformity
lower-limit = lower limit
upper-limit = upper limit
probability = probability
outcome = outcome
probability-that-the-quantity-is-inside-its = Probability: that the quantity is inside its limits, by Student's t about the estimate (JCGM 106, 7.3).

# report/html/scatter_page.rs
what-scatters = Random effects
sd-standard-deviation-of-one-deviation-a = sd: standard deviation of one deviation. A source is stated by the campaign or estimated from these readings (restricted maximum likelihood); each is a line of every budget.

# report/plot/normal.rs
normal-quantile = normal quantile
studentized-residual = studentized residual

# report/plot/values.rs
estimate-and-expanded-uncertainty = estimate and expanded uncertainty

# report/plot/bars.rs
bars-type = { $name } (Type { $type_b })

# report/html/compare_page.rs
least-squares-beside-the-published-closed-forms = Least squares and the published closed forms
comparison-with-the-published-closed-forms = Comparison with the published closed forms
group-by-group-without-earth-rate = { $square ->
    [yes] Group by group and without the Earth rate, which the formulas ignore, they agree with least squares to { $difference } of the value: they are its square special case.
   *[no] Group by group and without the Earth rate, which the formulas ignore, they differ from least squares by up to { $difference } of the value: these positions are not their square case.
}
mean-of-closed-forms = mean of closed forms
least-squares-all-readings = least squares, all readings
printed = printed
closed-form = closed form
least-squares-no-earth-rate = least squares, no Earth rate
least-squares = least squares
all = all
group-by-group = Group by group
what = what
computed = computed
what-seems-to-have-happened = probable cause
misprints-found = Misprints found

# report/compare_table.rs
closed-form-and-least-squares-differ-by = closed form and least squares differ by at most { $difference } of the value.

# report/conformity.rs

# report/site.rs
at-latitude-deg-and-m = at latitude { $latitude } deg and { $altitude } m
stated = , stated
site-gravity = gravity: { $gravity } { $unit }{ $u }{ $from }

# report/scatter.rs
scatter-tau = { $sd } { $unit }, tau { $tau }
estimated-zero = estimated: zero

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
these-readings-cannot-tell-it-from-their = these readings cannot distinguish it from { $others }: the sum of the variances is used; repeated readings at one level would separate them
the-unknowns-take-up-its-deviations = its { $count ->
    [one] one deviation is
   *[other] { $count } deviations are
} absorbed by the estimated parameters, so that its size cannot be estimated and u of { $names } cannot be given: { $levels }
more-readings = at least { $more ->
    [one] one more reading
   *[other] { $more } more readings
} at the inputs of others { $more ->
    [one] is
   *[other] are
} needed
more-mountings = at least { $more ->
    [one] one new mounting (a position measured again) is
   *[other] { $more } new mountings (positions measured again) are
} needed
more-campaigns = readings of at least { $more ->
    [one] one more campaign
   *[other] { $more } more campaigns
} are needed, with a column that numbers the campaigns
more-values = readings with { $more ->
    [one] at least one more value
   *[other] at least { $more } more values
} of { $column } are needed
no-degrees-of-freedom-are-left-to = no degrees of freedom are left to estimate it
in-each-reading-as-stated = in each reading as stated

# report/separation.rs
beyond-this-point-readings-respond-to-it = readings respond to it only away from this point, through a parameter that is zero or nearly zero here: state a value, a prior or a start
no-position-of-this-bench-would-separate-2 = no position of this bench would separate them
hides-in-and = { $last } is absorbed by { $join } and { $before }

# report/fit_checks.rs
lack-of-fit-by-replicates = { $rejected ->
    [yes] LACK OF FIT: the residuals exceed the scatter of replicates ({ $test }, p = { $p })
   *[no] the residuals agree with the scatter of replicates ({ $test }, p = { $p })
}
lack-of-fit-between-positions = { $rejected ->
    [yes] LACK OF FIT by position: the residuals between positions exceed the scatter of the readings of a position ({ $test }, p = { $p })
   *[no] the residuals between positions agree with the scatter of the readings of a position ({ $test }, p = { $p })
}
diagnose-says-what-is-missing = run `tumble diagnose` on this campaign to find what the model lacks
residuals-of-have-too-runs-of-one = residuals of { $sensor } have too { $few ->
    [yes] few
   *[no] many
} runs of one sign ({ $runs } for { $expected } expected, p = { $p }): something drifts or alternates
residuals-are-not-normal-shapiro-francia-w = residuals are not normal (Shapiro-Francia W' = { $w }, p = { $p })
lack-of-fit-over-an-input = LACK OF FIT over { $input }: a step function over eighths of its range explains more of the residuals of { $sensor } than noise does (chi-square { $chi_square } with { $dof } degrees of freedom, p = { $p })
lack-of-fit-or-correlation = a lack of fit of { $sensor } over { $inputs } cannot be distinguished from that correlation: state the correlation of the noise first
means-of-rows-scatter-too-much = residuals of { $sensor } are NOT INDEPENDENT: the standard deviation of means of { $rows } rows is { $ratio } times that of independent rows (p = { $p }), and u is too small by about this factor; describe the correlation of the noise in "scatter" ("over" a column of times)
means-of-rows-scatter-too-little = the standard deviation of means of { $rows } residuals of { $sensor } is { $ratio } times that of independent rows (p = { $p }): less noise than stated
residuals-are-correlated = residuals of { $sensor } are correlated: { $correlation } at { $rows } rows (p = { $p } for all lags)
row-is-far-from-the-model = SUSPICIOUS: row { $row } of { $sensor } differs from the model by { $residual } (w = { $w }, p = { $p } over all rows)
suspicious-reading-of-is-off-what-the = SUSPICIOUS: reading { $index } of { $sensor } differs by { $shift } from its prediction by the other readings (w = { $w }, p = { $p } over all { $tested } readings)
more-suspicious-readings = { $more } more suspicious readings: see the page or the JSON report

# report/fit_constraints.rs
no-values-meet-constraints-together-none-was = no values meet constraints { $named } together: none was applied
the-constraints-were-not-applied-the-readings = the constraints were not applied: not all parameters are estimable, or the solver did not converge
constraint-costs-in-chi-square = constraint { $index } ({ $text }) costs { $cost } in chi-square
rejected-the-readings-contradict-the-bounds-p = REJECTED: the readings contradict the bounds (p = { $p })
no-bound-is-active-the-estimate-is = no bound is active: the estimate is the free one

# report/monte_carlo.rs
the-first-order-does-not-describe-its = the first order does not describe { $id }: the limits of its { $level } % interval differ by up to { $sd } u; use the Monte Carlo interval

# fit/remarks.rs
all-values-of-lie-within-degrees-and = all values of { $name } lie within 6.3 degrees and would go round the circle as radians: are they radians?
rates-outside-those-of-the-table = { $name } = { $rate } deg/s: the rates of this table are { $least } to { $most } deg/s; is it in rad/s or another unit?
rates-would-be-round-as-radians = all values of { $name } lie within 6.3 deg/s and would be multiples of 5 deg/s if they were in rad/s: are they?
tilt-is-no-small-rotation = { $id } = { $tilt } deg is not a small tilt: with { $factor } as known, the readings of { $sensor } appear too large by orders of magnitude; are they in { $unit }, or in a thousandth of it?
factor-is-thousands-off-its-start = { $id } is { $ratio } times its start, and most of the readings depend on it: are the readings of { $sensor } in { $unit }?
every-reading-of-a-channel-is-the-same = every reading of { $sensor } is { $value } although its inputs change: the channel is stuck, or its resolution is too coarse
every-row-stands-there-several-times = every row occurs { $times } times with identical digits: if rows were entered more than once, u is too small by the square root of that number
condition-the-readings-hardly-tell-some-parameters = condition { $condition }: some parameters are nearly confounded; check the units of the inputs and the correlations
belongs-to-the-bench-and-stays-there = { $others } { $n ->
    [one] belongs to the bench, not to the unit
   *[other] belong to the bench, not to the unit
}.

# campaign/identity.rs
identity-unit = Unit
identity-serial = serial { $serial }
identity-place = Place
identity-operator = Operator
identity-instrument = Instrument
identity-certificate = certificate
identity-valid-to = valid to
identity-traceable-to = traceable to
identity-procedure = Procedure
identity-environment = Environment
identity-note = Note
instrument-no-longer-valid = the calibration of { $name } was valid to { $valid_to }, and the measurement was on { $date }
interval-sums-over-the-likelihood-of-the-variances = the readings determine some variances poorly: intervals are averaged over all variances and correlation times that the readings allow, weighted by their likelihood, instead of using the most likely values alone
scale-factor-errors-need-readings = nonlinearity, asymmetry, hysteresis and repeatability of scale factors are not computed for a streamed record: reduce it to readings first (tumble reduce)
scale-factor-error-has-limits = { $id } has limits, but these readings do not determine it: it needs at least three rates about the input axis of the sensor, and, if it compares them, both senses, both directions of approach or several runs

# sources of scatter
what-scatters-2 = random effect
scatter-sd = sd
scatter-u-sd = u(sd)
scatter-from = from
scatter-levels = levels
scatter-largest-share = largest share
scatter-share-of = { $share } % of { $id }
source-readings-of = readings of { $sensor }
source-priors = priors
source-per = { $of } per { $per }
source-over-per = { $of } over { $over } per { $per }
per-campaign = campaign
source-note-sentence = `{ $source }`: { $note }.
these-readings-cannot-tell-it-from-the-rest = these readings cannot distinguish it from the other random effects: the sum of the variances is used; repeated readings at one level would separate them

# words of several reports
correction-error-in = { $error } { $unit } in { $id }
from-to = { $a } to { $b }
conformity-is = Conformity: { $outcome } ({ $rule }).
tone-plain = Note
tone-good = In order
tone-caution = Caution
tone-bad = Not in order

# the certificate
angles-and-coefficients = Angles and coefficients
dcc-model = Model: { $models }.
dcc-least-squares = Least squares ({ $estimator }) from { $readings } readings with { $dof } degrees of freedom.
dcc-known = Known: { $known }.
dcc-assumed-zero = Assumed zero: { $assumed_zero }.
dcc-not-estimable = Not estimable and therefore not given: { $text }.
dcc-robust = Robust estimator: { $method }.
dcc-global-test = { $rejected ->
    [yes] Global chi-square test failed, p = { $p }.
   *[no] Global chi-square test passed, p = { $p }.
}
dcc-what-scatters = Standard deviations of the deviations that the uncertainties take into account.
dcc-values = { $estimated ->
    [yes] estimated ({ $levels } values)
   *[no] stated ({ $levels } values)
}
dcc-standard-uncertainty = standard uncertainty { $u }
dcc-covariance = Covariance of the estimates
dcc-jointly = all estimates jointly
dcc-relates-only-to-the-items = The results relate only to the items calibrated.
dcc-traceable = The results are metrologically traceable, by { $by }, to { $to }.
dcc-calibration-certificate = calibration certificate
dcc-method = Least-squares adjustment of a multi-position test
dcc-uncertainty = Expanded uncertainties: standard uncertainties multiplied by the coverage factor that is given with them
dcc-not-stated = not stated

# why Gauss-Newton ended

# why Gauss-Newton ended
stop-settled = converged: the last step is negligible
stop-unsettled = the scale factors of the weights did not converge in the last step
stop-limit = the limit of the number of steps was reached
stop-stalled = the steps remain large although the fit no longer improves: the readings determine some combination of parameters poorly
stop-no-descent = no fraction of the last step improves the fit
stop-out-of-range = numerical overflow after the last step

# report/changes.rs
before = before
after = after
difference = difference
per-day = per day
the-unit-has-changed = the unit has changed
no-change-beyond-the-uncertainties = no change beyond the uncertainties
f-test = F = { $f } with { $between_dof } and { $pure_error_dof } degrees of freedom
chi-square-with-degrees-of-freedom = chi-square { $statistic } with { $dof } degrees of freedom
all-parameters-together-p = all parameters together: { $test }, p = { $p }: { $verdict }
birge-ratio = Birge ratio
changes-only = only { $which }: { $ids }
date = date
serial = serial
file = file
last = last
per-year = per year

# report/html/changes_page.rs
two-calibrations-of-one-unit = Two calibrations of one unit
no-quantity-changed-by-more-than-the = No quantity changed by more than the uncertainties of the two calibrations allow.
changed-by-more-than-the-uncertainties-allow = Changed by more than the uncertainties allow: { $ids }.
no-input-is-shared-both-calibrations-count = No input is shared: both calibrations count as independent.
shared-by-both-calibrations-and-therefore-not = Shared by both calibrations, and therefore not counted twice: { $shared }.
u-expanded-uncertainty-of-the-difference-e-2 = U: expanded uncertainty of the difference; E_n = difference/U. Marked: significant with all quantities tested together (Holm).
difference-over-u-bars-u = difference over U (bars: U)
differences-of-the-two-calibrations-over-their = Differences of the two calibrations over their expanded uncertainties
each-difference-over-its-expanded-uncertainty-a = Each difference divided by its expanded uncertainty: a bar that does not include zero is a change.
the-weighted-mean-of-both-its-u = The weighted mean of both; its u is valid if the two agree, that is, if the Birge ratio is not well above 1.
combined-estimate = Combined estimate
history-of-calibrations = History of { $calibrations } calibrations
no-quantity-drifts-by-more-than-its = No quantity drifts by more than its calibrations scatter.
drift-beyond-the-scatter-of-the-calibrations = Drift beyond the scatter of the calibrations: { $drifts }.
leaves-its-limits = { $past ->
    [yes] `{ $id }` left its limits about { $day }.
   *[no] `{ $id }` leaves its limits about { $day }.
}
over-time = { $id } over time
with-bars-of-u-dashed-limits-line = `{ $id }` with bars of 2 u; dashed: limits; line: trend where it is significant.
over-time-2 = Over time

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
the-printed-equation-has-the-printed-chain = the printed equation has { $id }, the printed chain of rotations has not
coefficient-of-in-the-printed-equation = coefficient of { $id } in the printed equation
the-chain-of-rotations-gives-the-opposite = the chain of rotations gives the opposite sign
the-chain-of-rotations-gives-another-value = the chain of rotations gives a different value
reports-are-of-two-units = the reports are of different units, { $first } and { $second }: the differences are not changes of one unit
first-report-is-the-later-one = the first report ({ $first }) is later than the second ({ $second }): before and after are exchanged
quantity-at = { $id } at { $value }

# fit/azimuth.rs
azimuth-is-any = both components may be zero, so every direction is possible: the interval is the full circle, and u is that of a uniformly distributed angle
azimuth-interval = { $level } % interval { $low } to { $high }{ $unit }: the components are near zero, where it is not value - U to value + U

# fit/scale_factor.rs
largest-of-alike = the largest of { $of } deviations; { $alike } of them may be the largest within their noise, and k is that of the maximum of { $alike }
scatter-of-runs = standard deviation of the slopes of { $runs } runs, which includes the noise of their readings

# correction
left-out-not-estimable = not estimable: { $names }
its-line-does-not-bind = its equation does not depend on an input
its-line-has-no-slope-at-zero-input = its line has no slope at zero input
its-line-follows-no-rate = its line follows no rate and no specific force to first order (a bench without a chain says with "in_use" which columns are rates and specific forces)
its-norm-is-of-no-triad = its line is the norm of a vector that is not affine in as many readings, or its unit is none of rate or specific force
dcc-as-found = as found, before adjustment
dcc-as-left = as left, after adjustment
dcc-state-of-item = State of the item
dcc-title-and-state = { $title }: { $state }
dcc-probability = Probability of conformity { $probability }.
dcc-correction = inputs = matrix * (readings - bias), to first order, in frame { $frame }.
dcc-row = Row of the matrix for { $input }
angles-at-bounds = Upright lines: active bounds; there the bar is what the bounds leave of the interval.
source-weights = estimated weights (Kenward-Roger)

# report/diagnose/words.rs
effects-are-missing = { $n ->
    [one] one effect is missing from the model: { $names }
   *[other] { $n } effects are missing from the model: { $names }
}
effects-and = ; and{" "}
what-remains-is-more-than-noise = { $found }; the remaining residuals exceed the noise, and no effect of the catalogue explains them
effects-are-suspected = the residuals exceed the noise; suspected, but not probable enough for a name: { $suspected }
and-further-effects-are-suspected = { $found }; suspected beside it: { $suspected }
effect-with-probability = { $name }, probability { $p }
nothing-is-missing = { $noise ->
    [known] nothing is missing: the residuals are no larger than the noise
    [scatter] no effect is significant; the variances of the random effects are estimated from these readings, so completeness cannot be tested
   *[residuals] no effect is significant; the noise is estimated from the residuals, so completeness cannot be tested
}
unexplained = { $of ->
    [mission] the residuals exceed the noise, and no error of the unit, the start or the reference explains them
   *[campaign] the residuals exceed the noise, and no effect of the catalogue explains them
}
not-diagnosable = { $of ->
    [mission] nothing can be diagnosed: fewer than three values were measured
   *[campaign] nothing can be diagnosed: there are as many readings as unknowns, so no residuals remain
}
effect-named = { $name } (`{ $regressor }`)
effect-or-others = { $n ->
    [one] { $name }, or one other effect that this schedule cannot distinguish from it
   *[other] { $name }, or one of { $n } other effects that this schedule cannot distinguish from it
}
readings-were-averaged = ; { $from } readings were averaged to { $groups }, each of one setting over one interval of time
candidates-tried = { $candidates } candidates tried, { $distinct } of them distinct on this schedule; every p is corrected for their number; significance { $significance }{ $averaged }
one-further-reading-would-help = one further reading would discriminate, best at { $positions }
positions-or = ; or{" "}
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
it-was-stated-as-exact = it was stated as exact
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
position-tells-from = { $at } (discriminates { $n } of { $of })
the-model-has-all-but = the model contains all but { $share } of it
of-its-full-size = { $share } of its full size
u-after-includes = { $what ->
    [both] The u after the repair includes the possibility that an alias is the effect (each alias shifts the estimates differently, weighted by its probability), and the unexplained residuals; shift/u uses u without these.
    [aliases] The u after the repair includes the possibility that an alias is the effect (each alias shifts the estimates differently, weighted by its probability); shift/u uses u without it.
   *[remainder] The u after the repair includes the unexplained residuals; shift/u uses u without them.
}
what-is-unexplained-follows = the unexplained residuals follow { $name }
what-is-unexplained-differs = the unexplained residuals differ from reading to reading
with-a-standard-deviation-of = { $follows }, with a standard deviation of { $sd } { $unit }
probability-of-it-or-an-alias = { $p } that it or an alias is present, { $named } as named
fit-takes-the-effect-as-named = fit of this campaign assumes the effect as named ({ $named }); if it were one of its aliases, the estimates would change, most of all { $id } by { $by } { $unit } (u = { $u } as named); u_after of the diagnosis includes this
constraint-kept = kept as an equality
constraint-kept-at-its-limit = active: kept as an equality at its limit
constraint-met = inactive: met by the free estimate
constraint-wrong = contradicted by the readings: removed in the repaired model
constraint-left-out = left out: it contradicts others, or cannot be applied
constraint-state = constraint { $index }, { $text }: { $state }
holdout-after = , with the effects found by { $after }
holdout-skipped = { $n ->
    [one] ; { $n } cannot be left out, because it alone determines a parameter
   *[other] ; { $n } cannot be left out, because each alone determines a parameter
}
holdout = { $n ->
    [one] left out in turn and predicted from the others, { $n } position differs by { $before } of its standard uncertainty (rms; 1 is expected){ $after }{ $skipped }
   *[other] left out in turn and predicted from the others, { $n } positions differ by { $before } of their standard uncertainties (rms; 1 is expected){ $after }{ $skipped }
}
further-sensors-are-not-drawn = { $n ->
    [one] { $n } further sensor is not drawn.
   *[other] { $n } further sensors are not drawn.
}
gap-at = at
in-sd = in sd
in-u = in u
in-sensor = In `{ $sensor }`
rows-of = { $n } rows of { $motion }
errors-are-missing-from-the-mission = { $n ->
    [one] one error is missing from the mission
   *[other] { $n } errors are missing from the mission
}
faults-of-the-reference = { $n ->
    [one] one fault of the reference
   *[other] { $n } faults of the reference
}
single-wrong-values = { $n ->
    [one] one single wrong value
   *[other] { $n } single wrong values
}
ratio-unit = (ratio)
in-the-mission = In the mission
causes-tried = { $tried } causes tried, { $distinct } of them distinct in these data; every p is corrected for their number; significance { $significance }
refits = { $converged ->
    [yes] The full simulation was run { $times } times until the refit converged.
   *[no] The full simulation was run { $times } times; the refit did not converge.
}
the-gap-by-channel = The gap by channel
would-tell-best-first = Discriminating runs, best first
run-tells-of = { $motion } ({ $tells } of { $possible }, by { $by } sd)
phi-about-east = phi about east
phi-about-north = phi about north
phi-about-up = phi about up
velocity-east = velocity east
velocity-north = velocity north
position-east = position east
position-north = position north
navigation-errors = Navigation errors
what-was-found = effects found
two-u = two u
count-device = { $n ->
    [one] { $n } device
   *[other] { $n } devices
}
term-verdict = { $word }
devices-by = { $devices } by { $by }: { $verdicts }
title-regressor = regressor
wrote = wrote { $file }
wrote-both = wrote { $bench } and { $campaign }
note-nothing-found = { $what ->
    [error] note: no error was found, so no mission is written
   *[effect] note: no effect was found, so no repaired model is written
}

# report/diagnose/table.rs
not-determined = not determined
why = why
and-more = { $shown } and { $more } more
chi-square = chi-square
residual-sd = residual sd
max = max
sd-before = sd before
max-before = max before
sd-after = sd after
max-after = max after
noise-floor = noise floor: { $noise }
as-given = as given
nearest-of-the-catalogue-would-take-off = Best combination of the catalogue: { $names } would explain { $share } %, but the remaining residuals exceed the noise, so it is not accepted.
mean-gap = mean residual
level = level
p-alone = p alone
shift-u = shift/u

# report/html/diagnose_page.rs
what-is-missing = What is missing
unknown = unknown
noise-sd = noise sd
common-to-all = common to all
the-repaired-model-does-not-determine-it = not estimable in the repaired model
stated-2 = Stated
title-probability = Probability
explains = explains
fits-not-significantly-worse = Fits not significantly worse
only-through-small-terms = Through tilt-dependent terms only
no-position-of-this-bench-tells-it = No position of this bench distinguishes it from
why-it-happens = Why it happens
to-confirm = To confirm
the-model = The model
with-what-was-found = with the effects found
the-pattern = The pattern
mean-residual-at-each-state-of-the = Mean residual at each state of the joints, the most significant first; bars are in standard deviations.
marked-shifts-of-more-than-twice-their = Marked: shifts of more than twice their standard uncertainty.
what-it-does-to-the-estimates = Effect on the estimates
where-the-gap-is = Where the residuals are
factor = factor
means-of-the-residuals-with-the-model = Means of the residuals of the model as given, each level separately; bars are in standard deviations.
in-the-model = in the model
strongest-further-candidate = strongest further candidate
p-of-what-is-left = p of the remaining residuals
the-gap-shrinks-step-by-step = The gap shrinks step by step
the-gap-as-given = The gap as given
taken-as-known = Taken as known: { $known }.
priors-entered-as-rows-of-their-own = Priors entered as additional rows: { $priors }.
readings-are-independent = { $from ->
    [stated] The readings scatter independently, as their stated uncertainties say.
    [replicates] The readings scatter independently, as their replicates say.
   *[residuals] The readings of one sensor have independent errors of equal standard deviation, estimated from the residuals of the final model only.
}
the-models-are-fitted-exactly-gauss-newton = The models are fitted exactly (Gauss-Newton); the candidates are compared at their solution.
gauss-newton-does-not-converge-here-so = Gauss-Newton does not converge here, so the linear estimator was diagnosed.

# report/html/diagnose_figure.rs
each-reading-minus-the-model-as-given = Each reading minus the model, as given.
each-reading-minus-the-model-circles-with = Each reading minus the model: circles for the model as given, discs for the model with the effects found.
readings-are-grouped-by-which-the-gap = Readings are grouped by { $factor }, which explains most of the residuals; a bar is the mean of a group for the model as given.
one-reading-in-is-drawn-and-all = One reading in { $every } is drawn, and all outlying ones.
every-reading-is-drawn = Every reading is drawn.
residual-sd-in-figure = { $repaired ->
    [yes] { $id }: residual sd { $before } { $unit } before and { $after } after
   *[no] { $id }: residual sd { $before } { $unit }
}

# report/plot/gap.rs
readings-in-their-order = readings in their order
readings-by = readings by { $factor }
noise-standard-deviations = noise, ±2 standard deviations

# report/batch.rs
reasons = Reasons
devices-tested = tested
expected-by-chance = expected by chance
beyond-chance = beyond chance
chance-alone-finds = A device may have several reasons. Expected by chance: devices that the test finds at { $level } where nothing is wrong. Beyond chance: devices that it finds at { $level } over all devices together.
term-reason = { $word ->
    [malformed] no readings of this campaign
    [not-estimable] not estimable
    [stuck-channel] stuck channel
    [global-test] global test failed
    [no-convergence] no convergence
    [lack-of-fit] lack of fit
    [suspicious-readings] suspicious readings
    [repeated-rows] repeated rows
    [outside-limits] outside limits
   *[other] { $word }
}
sd-of-devices = sd of devices
scale-factor-errors-have-columns = nonlinearity, asymmetry, hysteresis and repeatability of scale factors have columns where "limits" ask for them, for example of { $id }
verdict = verdict
limits = limits

# report/html/batch_page.rs
one-fit-for-each = One fit for each
model-of = Model of { $sensor }
all-are-accepted = All { $devices } are accepted.
of-are-not-accepted-rejected-a-rank = { $bad } of { $devices } are not accepted: { $rejected } rejected (a rank defect, a failed global test, no convergence), { $malformed } whose readings do not belong to this campaign.
conformity-rule-pass-undecided-fail = Conformity (rule `{ $decision }`): { $pass } pass, { $undecided } undecided, { $fail } fail.
in-no-quantity-do-devices-differ-by = In no quantity do devices differ by more than the scatter of their readings.
devices-differ-by-more-than-their-readings = Devices differ by more than the scatter of their readings (p < 0.01) in { $names }: production scatters more than the measurement.
fitted-by-the-factorisation-of-a-schedule = { $common } fitted with the factorisation of a schedule that several devices share, { $alone } individually.
devices = devices
p-if-alike = p if alike
least = least
most = most
accepted-devices-only-sd-between-devices-u = Accepted devices only. sd: between devices; u: root mean square of the devices' standard uncertainties; sd of devices: the part of sd that the scatter of their readings does not explain; p if alike: probability of such an sd if all devices were alike (F, or chi-square where uncertainties are stated).
batch-page-over = { $id } over { $devices }
histogram = { $limited ->
    [yes] Histogram of `{ $id }`; curve: expected from the scatter of the readings alone; dashed: limits.
   *[no] Histogram of `{ $id }`; curve: expected from the scatter of the readings alone.
}
distributions = Distributions
each-histogram-shows-the-accepted-devices-the = Each histogram shows the accepted devices; the curve is expected from the scatter of the readings alone; dashed lines are limits. Outlying values are counted in the last bar.
devices-that-are-not-in-order = Devices that are not in order
the-first-devices-that-are-not-in-order = The worst { $listed } of them:
devices-that-stand-apart = Outlying devices
no-accepted-device-stands-apart-from-the = No accepted device is an outlier at 1 % over all devices and quantities.
z-value-median-mad-beyond-what-a = z = (value - median) / (1.4826 MAD), beyond the limit of a normal distribution at 1 % over all devices and quantities; largest first, at most 50. For a single report run `tumble fit` with the readings of that device.
by-lot = { $id } by lot
mean-of-in-each-lot-line-mean = Mean of `{ $id }` in each lot; line: mean of all devices; dashed: three standard deviations of a lot's mean, from the scatter within lots; triangles lie beyond.
control-charts = Control charts
no-lot-lies-beyond-its-control-limits = No lot lies beyond its control limits.
lots-beyond-their-control-limits = Lots beyond their control limits:
points-are-means-of-lots-the-line = Points are means of lots, the line is the mean of all devices, dashed lines are three standard deviations of a lot's mean from the scatter within lots; triangles lie beyond.

# report/navigate_diagnose_table.rs
rows-of-other-scenarios-left-out = ; { $rows } rows of other scenarios left out
motion = motion
time-h = time, h
single-values-far-off = outliers
time-s = time, s
these-data-cannot-show = These data cannot show { $sources }.
the-mission-had-and-has-with-it = { $before } before, { $after } with the error included
absurd = (implausible size)
rms = rms
noise-of-mission = { $stated ->
    [yes] the stated standard uncertainties
   *[no] u is not stated for every channel, so it is estimated from the residuals (lack of fit cannot be tested)
}
from-residuals = from residuals

# report/html/navigate_diagnose.rs
measured-navigation-errors = Measured
values-are-changes-of-the-missions-errors = Values are changes of the mission's errors.
gap-in-standard-uncertainties = Residuals, measured minus predicted, in standard uncertainties
channel = channel
values = values
rms-before = rms before
rms-after = rms after
gap-of = Residuals of `{ $name }`{ $where_ }
gap-of-root-mean-square-before-after = Residuals of { $name }{ $where_ }: root mean square { $before } before, { $after } after
what-is-left = remaining residuals
what-is-left-of-with-two-standard = Remaining residuals of `{ $name }`{ $where_ }, with two standard uncertainties
in-time = In time
title-one-more-position-would-tell-it = One more position discriminates them
effect-2 = effect

# cli
error-what = error: { $text }
error-expected = expected { $text }
error-option = option { $text }
error-found = found { $text }
error-in = in { $file }
error-line = , line { $line }, column { $column }
error-at = at { $path }

# plan, foresight, navigate, reduce, noise
correlation-with = { $r } with { $partner }
uncertainty-depends-on-a-value = the uncertainty of { $untold } depends on the value of { $needs }, and none is stated: at zero the effect vanishes; state it with --at { $first }=VALUE or a "start"
values-checked-by-no-other = { $n ->
    [one] { $n } value has no redundancy
   *[other] { $n } values have no redundancy
}
bounds-not-counted = { $n ->
    [one] { $n } bound is not taken into account: a bound lowers an uncertainty only where it is active
   *[other] { $n } bounds are not taken into account: a bound lowers an uncertainty only where it is active
}
is-not-estimable = { $text } is not estimable
value-times = { $value } ({ $count } times)
separated-by = separated by { $position }
arcsec-of = { $e } arcsec of { $id }
u-at-equal-effort = { $cost ->
    [yes] u at equal cost
   *[no] u at equal readings
}
cannot-be-determined-by-any-choice = { $text } cannot be determined by any choice of these candidates
to-run-in-this-order = To run, in this order
fewer-readings-cannot-reach-it = ; fewer readings cannot reach it
moves-by = { $parameter } by { $u } u
shows-from = shows from
and-shifts = and shifts
with-criterion = { $proof } (criterion { $criterion })
readings-at-a-spot = { $n } at { $across } { $x }, { $up } { $y }
title-effects = Effects
plan-rank = rank { $rank }, { $dof }
combinations-cannot-be-estimated = { $n ->
    [one] { $n } combination of unknowns cannot be estimated.
   *[other] { $n } combinations of unknowns cannot be estimated.
}
term-sd-from = { $word }
term-point-from = { $word }
term-criterion = { $word }
count-mounting = { $n ->
    [one] { $n } mounting
   *[other] { $n } mountings
}
count-rate-change = { $n ->
    [one] { $n } rate change
   *[other] { $n } rate changes
}
count-direction = { $n ->
    [one] { $n } direction
   *[other] { $n } directions
}
count-segment = { $n ->
    [one] { $n } segment
   *[other] { $n } segments
}
count-stretch = { $n ->
    [one] { $n } stretch
   *[other] { $n } stretches
}
count-odd-sample = { $n ->
    [one] { $n } odd sample
   *[other] { $n } odd samples
}
segments-by = { $n } by { $by }
to-s = to, s
tilt = tilt
carried-by = by
none-at-the-equator = none (at the equator)
schuler-earth-foucault = Schuler { $schuler } min, Earth { $earth } h, Foucault { $foucault }
quantity-azimuth = azimuth error
quantity-velocity = velocity error
quantity-position = position error

# report/noise_table.rs
below = below (95 %)
their-sum-describes = { $well ->
    [yes] Their sum describes the deviations
   *[no] Their sum does not describe the deviations
}
no-coefficients = { $why ->
    [constant] No coefficients: all samples are equal
    [short] No coefficients: fewer than five octaves of averaging times, which need 80 samples with at most a tenth of them missing
   *[undescribed] No coefficients: no sum of the terms describes these deviations
}
described-from = Averaging times below { $from } s are left out: a filter of the sensor, or samples that are held or quantized, are none of these terms
samples-left-out = Samples left out as if they were missing: { $events }
random-walk-sampled = The rate random walk is modelled as sampled at the end of each interval of { $interval } s, not as averaged over it: this describes the deviations better
chi-square-dof-p = chi-square { $chi }, { $dof } dof, p { $p }
in-stretches = in { $n } stretches
samples-mean = { $samples } samples in { $unit }, mean { $mean }.
tau-s = tau, s
allan = Allan
edf = edf
hadamard = Hadamard
modified = modified

# report/html/noise_page.rs
noise-of-a-record = Noise of a record
sampling-rate = Sampling rate
overlapping-allan-deviation-of-samples-with-its = Overlapping Allan deviation of { $samples } samples with its { $level } % chi-square intervals, and the fitted coefficients as a line.
allan-deviation-of-against-averaging-time-on = Allan deviation of { $column } against averaging time on logarithmic axes; the table has its numbers.
allan-deviation = Allan deviation, { $unit }

# report/reduction_table.rs
segments-begin-and-end-with-blocks-of = Segments begin and end with blocks of { $block } samples.
noisier-segment = { $apart ->
    [yes] { $column } in segment { $segment } is { $times } times noisier from sample to sample than elsewhere: its u is based on its own noise and on that of similar segments.
   *[no] { $column } in segment { $segment } is { $times } times noisier than elsewhere: its u is as much larger.
}
segment-in-the-mean = segment { $segment }, { $column }: { $events } (in the mean)
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
a-second = { $samples }, { $rate } a second
segments = Segments
not-used-of-means-have-a-slope = { $segments }, { $stretches } not used. { $sloping } of { $all } means have a slope (p < 0.01) that their noise does not explain; { $odd } within segments (none was left out of a mean).
the-whole-record-segments-are-shaded = The whole record; segments are shaded.
panels-one-for-each-column-against-time = { $panels } panels, one for each column, against time; { $segments } shaded segments.
record = Record
means = Means
u-on-either-side-of-a-mean = The mean +- 1.96 `u` covers 95 %. `u` is estimated from all segments of a column together and includes the uncertainty of this estimate. For comparison: u for white noise, with the sum of the autocorrelations, and as the Allan deviation at the segment's length.
column = column
odd = odd
not-used-2 = Not used

# report/navigate_table.rs
h-in-steps-of-s = { $duration } h in steps of { $step } s
duration = Duration
vertical-channel = Vertical channel
scenario = scenario
perfect-unit-a-perfect-unit-the-navigators = `perfect_unit`: a perfect unit, that is, the error of the navigator itself.
azimuth = azimuth
velocity = velocity
what-the-calibrations-uncertainty-does = What the calibration's uncertainty does
linear-covariance = linear covariance
monte-carlo-draws = Monte Carlo, { $draws } draws

# report/html/navigate.rs
convention = Convention
periods = Periods
root-mean-square-errors = Root mean square errors
against-the-first-motion = Relative to the first motion
errors-in-time = Errors in time: { $scenario }
at-most-at-the-end = { $label }: at most { $most } { $unit }, { $last } { $unit } at the end
of-against-time = { $what } of { $of } against time; { $ends }.
curve-of = { $what } of { $of }
after-h-the-position-is-off-by = { $motion }: after { $time } h the position error is { $position } m (rms { $position_rms } m), the azimuth error { $azimuth } arcsec (rms { $azimuth_rms } arcsec)
with-most-of-it-from-position-rms = { $text }, in scenario `{ $scenario }`; mainly from { $sources } (position, rms)
position-at-the-end-m = position at the end (m)
ratios-of-root-mean-squares-where-the = Ratios of root mean squares; - where the error in the first motion is no larger than that of the navigator itself.

# report/plan_table.rs
every-remounting-scatters-sd-rad-for-a = random change of { $id } at every remounting: sd { $sd } (rad for a tilt)
zero-no-parameter-has-a-start-prior = zero (no parameter has a start, prior or --at)
plan-table-others = { $count } others = 0
in-with-cost = { $readings } in { $mountings } with { $rate_changes }, cost { $cost }
needs-a-value = needs a value
largest-near-the-reference = largest near the reference
predicted-u = predicted u
strongest-correlation = strongest correlation
undetected-fault = undetected fault
so-many-values-what-a-diagnosis-could = too many values: detectable effects are not predicted, and the values are not listed
counted-above-with-tilts-of-arcsec-the = included above: with tilts of { $tilts } arcsec, the uncertainty of { $known } adds { $u }{ $unit } to { $parameter }
not-counted-the-uncertainty-of-acts-through = not included: the uncertainty of { $known } acts through the tilts, whose size is unknown before the measurement; tilts of { $tilts } arcsec would add { $u }{ $unit } to { $parameter } (--tilts { $tilts } includes it)
plan-table-times = { $length } times
best-of-all-choices = { $limited ->
    [yes] the best: all { $all } choices of these candidates at this cost were tried (proven 100 %)
   *[no] the best: all { $all } choices of these candidates were tried (proven 100 %)
}
proven-efficiency = { $limited ->
    [yes] proven to be at least { $share } as good as the best possible choice of these candidates at this cost
   *[no] proven to be at least { $share } as good as the best possible choice of these candidates
}
the-bound-allows-more-mountings-than-the = the bound is for more mountings than the cost allows, so the choice may be the best
so-few-portions-cannot-follow-the-best = with so few portions the optimal weights can only be approximated roughly; more or smaller portions come nearer
the-bound-itself-may-be-too-high = the bound itself may be { $gap } too high
no-angle-is-worth-moving = moving angles between the candidates does not improve the schedule, in steps down to { $resolution } deg
angles-moved = { $finished ->
    [yes] angles moved off the candidates at { $mountings }, in steps down to { $resolution } deg: { $gain } % better than the choice
   *[no] angles moved off the candidates at { $mountings }, in steps down to { $resolution } deg (search stopped at its limit): { $gain } % better than the choice
}
within-a-budget-of-for-what-was = cost limit of the search: { $cost }
at-no-more-cost-than-the-given = cost limit of the search: that of as many readings of the given schedule, { $cost } (--any-cost: no limit)
without-it-nothing-determines = without it { $parameter } is not estimable
without-it-u-of-grows-by = without it u of { $parameter } grows by { $share } %
it-adds-little = it changes little
u-of-their-coefficients-and = u of their coefficients { $p } and { $q }
nothing-tells-them-apart = nothing distinguishes them
and-both-in-the-model-before = { $a } and { $b }, both in the model: before, { $before }
with-the-added-positions = with the added positions, { $after }
positions-share-deviations-planned-for = readings share deviations ({ $line }); the chosen positions are planned for { $levels } (a sweep takes the value of the schedule's first reading; --candidates FILE offers others)
no-candidate-would-separate-it-but-all = no candidate would separate them, but all candidates have { $held } only (--candidates FILE takes others)
of-is-found-with-probability-where-the = { $effect } of { $size } is found with probability { $power } where the u of its coefficient { $coefficient } is at most { $u }
the-goal-counts = { $some ->
    [yes] the goal counts { $counted }, but not { $derived }
   *[no] the goal counts { $counted }
}
this-is-the-cheapest-schedule-that-was = this is the cheapest schedule that was found; that none is cheaper is not proven
determined-instead-2 = determined instead: { $instead }
leverage = leverage
its-largest-effect-on-an-angle = largest undetected change of an angle
no-candidate-discriminates = No candidate discriminates { $a } and { $b }, so nothing is added.
seed-of-starts-ended-here = , seed { $seed }, { $hits } of { $starts } starts ended here
of-its-readings-chosen-among-candidate-portions = { $chosen } of its readings chosen among { $candidates } candidate portions, criterion { $criterion }{ $starts }
even-all-candidates-together-do-not-determine = Even all candidates together do not determine `{ $id }`.
u-given = u given
u-better = u better
gain = gain

# report/html/plan_page.rs
noise-of-2 = Noise of { $id }
judged-at-2 = Judged at
the-two-effects = The two effects
the-given-schedule = The given schedule
the-better-schedule-in-full = The better schedule in full
its-readings = Its readings
what-rests-on-each-reading = Reliability of each reading
model-and-noise = Model and noise
the-better-schedule-2 = The better schedule
goal-reached = { $reached ->
    [yes] The goal is reached: the largest uncertainty is { $share } of its limit{ $proof }.
   *[no] The goal is not reached: at best, the largest uncertainty is { $share } of its limit.
}
still-to-run-2 = Still to run: { $work }.
predicted-standard-uncertainties = Predicted standard uncertainties
at-equal-effort = { $cost ->
    [yes] At equal effort: the given schedule repeated, or cut, to the cost of the better one.
   *[no] At equal effort: the given schedule repeated, or cut, to the readings of the better one.
}
mounting = mounting
position-values-in-the-order-to-run = position, values in the order to run
why-it-is-there = why it is there
in-this-order-a-drift-of-one = In this order, a drift of one standard deviation over the run shifts a parameter by at most { $share } of its uncertainty.
where-the-positions-lie = Where the positions lie
squares-the-schedules-positions = Squares: the schedule's positions.
dots-candidates-squares-the-given-schedule-discs = Dots: candidates. Squares: the given schedule. Discs with numbers: the better schedule and its readings at each position.
then-at-a-reading-in-its-u = then at a reading, in its u
cannot-be-distinguished-from = cannot be distinguished from
effects-that-would-show = { $better ->
    [yes] Effects that would show on the better schedule, one row for each distinguishable direction
   *[no] Effects that would show on this schedule, one row for each distinguishable direction
}
nearly-alike-cosine-beside-the-model-and = Nearly alike: cosine after projection on the model, and the size from which the two can be distinguished.
taken-up-by = absorbed by
effects-that-never-show-estimated-parameters-take = Effects that can never be detected: estimated parameters absorb them and are biased
zero-at-every-position = Zero at every position: { $effects }
not-tried-without-a-column-kinds-of-2 = Not tried without a column `{ $column }`: { $families }
effects-of-the-catalogue-were-tried-in = { $tried } effects of the catalogue were tried, in { $distinct } distinct directions after projection on the model.
what-a-diagnosis-could-find = What a diagnosis could find
not-every-unknown-has-a-predicted-uncertainty = Not every unknown has a predicted uncertainty at the point that was judged.
every-unknown-can-be-estimated-the-least = Every unknown can be estimated; the least certain angle is `{ $id }` with u = { $u } arcsec.
every-unknown-can-be-estimated = Every unknown can be estimated.
each-value-leverage-minimal-detectable-bias-and = Each value: leverage, minimal detectable bias (0.1 %, 80 %), and what it does undetected

# report/plot/deviations.rs
averaging-time-s = averaging time, s

# report/plot/record.rs
time-since-the-first-sample-s = time since the first sample, s

# report/plot/positions.rs
positions-deg = { $across } (deg)
deg-across-deg-up = { $across } (deg) across, { $up } (deg) up

# report/foresight.rs
regressor-of-sensor = { $regressor } of { $sensor }
foresight-nearly = nearly { $regressor } ({ $cosine })
apart-from = { $regressor } ({ $cosine }, apart from { $apart })
none-would-show-the-estimated-parameters-take = none would be detectable: the estimated parameters absorb every effect that these positions excite
u-where-only-the-residuals-tell-the = ; { $more } u if the noise is known from the residuals only
nothing-where-only-the-residuals-would-tell = ; no effect if the noise is known from the residuals only
smallest-size-that-shows-u-significance-for = smallest size that shows: { $size } u (significance { $significance } for { $directions } together, power { $power }){ $residuals }
term-event = { $word }
before-repair = before
after-repair = after
repair-shift = shift
title-devices-by = { $devices } by { $by }
gauss-newton-did-not-converge-after = Gauss-Newton did not converge after { $steps }: { $stop }.
gauss-newton-converged-and-differs = Gauss-Newton converged after { $steps }. The linear estimates (one step from the reference point) differ by more than 0.1 u (exact minus linear): { $what }.
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
iteration = iteration
weighted-sum-of-squares = weighted sum of squares
step-of-the-predictions = change of the predictions (norm)
share-of-the-step = share of the step

# cli/guide/view.rs
guide-position = position { $label }: { $setting }
guide-not-predicted = reading { $reading }, { $place }: not yet predicted by the others
guide-agrees = reading { $reading }, { $place }: agrees ({ $sd } sd)
guide-disagrees = reading { $reading }, { $place }: DOES NOT AGREE ({ $sd } sd)
guide-time-goes-back = time_s goes back from { $before } to { $now }
guide-likely-at = { "  " }likely at reading { $reading }: { $kind }
guide-likely = { "  " }likely: { $kind }
guide-not-told = { "  " }the cause cannot be identified yet:
guide-explanation = { "    " }{ $probability }  reading { $reading }, { $kind }: { $what }
guide-more = { "    " }and { $count } more
guide-goal-open = { "  " }{ $id }: not estimable yet, goal { $goal } { $unit }
guide-goal = { "  " }{ $id } = { $value } { $unit }, u = { $u }, goal { $goal }: not yet
guide-goal-met = { "  " }{ $id } = { $value } { $unit }, u = { $u }, goal { $goal }: met
guide-diagnosis = { "  " }diagnosis: { $verdict }
guide-size = , { $value } { $unit }, u = { $u }
guide-effect = { "    " }{ $name } ({ $terms }){ $size }, probability { $probability }
guide-nothing-missing = { "  " }probability that no effect is missing or all are named: { $probability }; effects not yet observable: { $unseen }
guide-unreachable = { "  " }{ $id }: its goal cannot be reached with these positions
guide-next = next: { $place } ({ $nats } nats for a cost of { $cost })
guide-next-apart = next: { $place } (discriminates { $between })
guide-next-again = next: { $place } (the same position again)
guide-moving = the bench moves
guide-held = { $place }: held for { $seconds } s
guide-held-mean = , { $sensor } u = { $u } { $unit } (wanted { $wanted })
guide-held-wait = { $place }: held for { $seconds } s{ $means }; hold it { $wait } s longer
guide-held-never = { $place }: held for { $seconds } s{ $means }; the wanted u cannot be reached by holding; 'take' reads the mean so far
guide-read = { $place }: read; set the next position
guide-left = { $place }: LEFT after { $seconds } s{ $means }, and not read
guide-port-is-back = the serial port { $name } is there again
guide-which = position? Several agree with what was read; answer with a line: position LABEL
  { "  " }{ $candidates }
guide-view-set = Set
guide-view-held = Held
guide-view-goals = Goals: u against what is wanted
guide-view-goal = { $id }: u = { $u }, wanted { $goal } { $unit }
guide-view-residuals = Residuals in standard deviations, by reading
guide-view-missing = What may be missing: probability
guide-view-nothing = nothing missing, or all of it named
guide-reached = done: every goal is met, and no effect is missing or all are named; { $readings } readings, cost { $cost }
guide-nothing-to-gain = stopped: no position of this schedule gives further information on what is still wanted; { $readings } readings, cost { $cost }
guide-most-readings = stopped: the limit of { $readings } readings was reached (--most); cost { $cost }
term-mistake = { $word ->
    [turned-180] a joint turned by 180 degrees
    [another-position] another position of the schedule
    [wrong-sense] a rate of the wrong sense
    [exchanged-axes] exchanged joints
    [exchanged-sensors] exchanged sensors
    [slipped-mounting] a mounting that slipped
    [bad-reading] a bad value
    [missing-effect] an effect that the model lacks
   *[other] { $word }
}

# Run sheets and drawings of benches
run-sheet = Run sheet: { $bench }
run-sheet-how = Take the readings in this order. Write each value into its empty cell; the table of the same readings as CSV (--sheet FILE.csv), filled in, is read with --readings.
readings-in-the-order-to-run = Readings in the order to run
number-sign = no.
mounting-named = Mounting { $name }
mountings = Mountings
cost = Cost
cost-so-far = cost so far
remarks = remarks
bench-drawn = Drawing of the bench { $bench }: { $joints }; the unit with its axes, gravity and the Earth rate.
unit-at-the-start = The unit as the mission begins: heading, pitch and roll, with the amplitudes that they swing by.
unit-drawn = The unit at { $angles }.
heading-angle = heading
pitch-angle = pitch
roll-angle = roll
bench-at-first-reading = The bench as the first reading has it: joints as rings about their axes from the ground (outside) to the unit (inside), with tilts at zero. Red arcs turn.
east-axis = E
north-axis = N
up-axis = up
gravity-arrow = gravity
earth-rate-arrow = Earth rate
