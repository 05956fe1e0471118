# Sentences and terms of the reports in English. Arguments are formatted before they come here.

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
count-step = { $n ->
    [one] { $n } step
   *[other] { $n } steps
}
degrees-of-freedom = degrees of freedom

## Closed vocabularies of the reports, as JSON has them

state-free = free
state-at-bound = at-bound
state-not-estimable = not-estimable
outcome-pass = pass
outcome-fail = fail
outcome-undecided = undecided
estimator-exact = exact
estimator-linear = linear
distribution-normal = normal
distribution-rectangular = rectangular
distribution-triangular = triangular
distribution-t = t
from-stated = stated
from-estimated = estimated
constraint-equality = equality
constraint-inactive = inactive
constraint-active = active
constraint-contradictory = contradictory
constraint-not-applied = not-applied
side-lower = lower
side-upper = upper
side-norm = norm

# report/fit_table.rs
tumble-fit-on = tumble { $tumble }: { $estimator } fit on { $bench }
derived = derived
parameter = parameter
estimate = estimate
dof = dof
unit = unit
state = state
rank-of-degrees-of-freedom = { $reading }{ $priors }, rank { $rank } of { $parameters }, { $dof } degrees of freedom
fit-table-condition = , condition { $condition }
rejected-the-readings-scatter-more-than-their = REJECTED: the readings scatter more than their stated uncertainties allow
accepted = accepted
global-test-chi-square-with-degrees-of = global test: chi-square { $chi_square } with { $dof } degrees of freedom, p = { $p }, factor { $sd }: { $verdict }
that-of-rounding-to-its-last-digit = that of rounding to { $step } (its last digit, over sqrt 12): its readings scatter no more
the-rounding-of-its-readings-which-show = the rounding of its readings, which show no scatter
estimated-from-these-readings = estimated from these readings
residual-sd-of = residual sd of { $sensor }: { $sd }, { $how }
residual-sd-of-none-no-degrees-of = residual sd of { $sensor }: none (no degrees of freedom), so no uncertainty can be given
inconsistent-disagrees-with-the-other-sights-by = INCONSISTENT: { $sensor } disagrees with the other sights by { $mean_residual_deg } deg on average (another side of the target? a point sighted wrongly? a start too far away?)
fit-table-note = note: { $remark }
fit-table-known = known: { $known }
assumed-zero = assumed zero: { $assumed_zero }
note-one-linear-step-is-not-enough = note: one linear step is not enough here: Gauss-Newton would go on by more than 0.1 u in { $differ }; fit without --linear
no-reading-responds-to-at-the-reference = no reading responds to { $moved } at the reference point, where all that they are multiplied by is zero: started beside it
held-where-the-iteration-began-since-the = held where the iteration began, since the exact model determines them too weakly beyond it: { $held }
the-linear-estimates-linear-are-the-same = the linear estimates (--linear) are the same within 0.1 u
the-linear-estimates-linear-differ-by-more = the linear estimates (--linear) differ by more than 0.1 u (exact minus linear): { $differ }
gauss-newton-converged-after = Gauss-Newton converged after { $steps }; { $linear }
gauss-newton-not-converged-after = Gauss-Newton NOT converged after { $steps } ({ $stop })
estimable-combination = estimable combination
u-holds-only-for-as-held-another = U holds only for { $held } as held: another value of it, { $by } { $unit } away, changes { $shifts }
not-estimable-is-free = NOT ESTIMABLE: { $text } is free
no-reading-responds-to-it-at-this = no reading responds to it at this point
no-reading-responds-to-it = no reading responds to it
only-estimable-here = only { $only } { $n ->
    [one] is
   *[other] are
} estimable here
a-reading-at-would-separate-it = a reading at { $keys } would separate it
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
budget-of = budget of { $id }{ $unit }
correlation = correlation
less-than-half-weight-readings = ; less than half weight: readings { $named }
fit-checks-table-constraints = constraints: { $verdict }
is-at-a-bound-interval-to-of = { $id } is at a bound: { $level } % interval { $low } to { $high } { $unit } (of the free estimate, cut to what is allowed)
is-at-a-bound-and-the-whole = { $id } is at a bound, and the whole { $level } % interval of the free estimate is not allowed: bound and readings disagree
yes = yes
monte-carlo = Monte Carlo
mean = mean
low = low
high = high
shortest-low = shortest low
shortest-high = shortest high
first-order-agrees = first order agrees
trials-seed = { $trials } trials, seed { $seed }
coverage-ellipsoid-of-k-p = coverage ellipsoid of { $order }: k_p = { $k }

# report/correction.rs
the-lines-are-linear-in-the-inputs = The lines are linear in the inputs: this correction is exact.
within-the-range-of-the-calibration-it = Within the range of the calibration ({ $within }) it leaves at most { $errors }
below-the-standard-uncertainty-of-the-calibration = , below the standard uncertainty of the calibration everywhere there.
no-part = no part
within-of-that-range-it-stays-below = ; within { $part } of that range it stays below the standard uncertainty of the calibration. Beyond, use the exact lines: `tumble apply` does.
the-exact-lines-tumble-apply-leave-nothing = ; the exact lines (`tumble apply`) leave nothing.
correction-otherwise = { $id } (otherwise { $otherwise }{ $unit })
these-sensors-do-not-determine-give-it = These sensors do not determine { $given }: give it as a column beside the readings.
correction-none-of-the-sensors-follows-a = correction: none of the sensors follows a rate w_* or a specific force a_* that the fit determines
correction-first-order-inputs-matrix-readings-bias = correction, first order: inputs = matrix * (readings - bias)
input = input
bias = bias
is-left-out = { $sensor } is left out: { $why }.

# report/html/fit_page.rs
calibration-every-angle-and-coefficient-with-its = Calibration: every angle and coefficient with its uncertainty
made-by = made by
tumble-the-same-inputs-give-the-same = tumble { $version }; the same inputs give the same bytes
sha-of = SHA-256 of { $name }
bench = Bench
source = Source
campaign = Campaign
model = Model
one-least-squares-step-from-the-reference = one least-squares step from the reference point
gauss-newton-on-the-exact-rotations = Gauss-Newton on the exact rotations
estimator = Estimator
residuals-and-correlations = Residuals and correlations

# report/html/fit_answer.rs
result = Result
not-everything-is-estimable-is-free-see = Not everything is estimable: `{ $text }` is free. See below.
the-readings-scatter-more-than-their-stated = the readings scatter more than their stated uncertainties allow: the model misses something, or the uncertainties are too small
the-readings-scatter-as-their-stated-uncertainties = the readings scatter as their stated uncertainties say
global-test-chi-square-with-p = Global test: { $words } (chi-square { $chi_square } with { $dof }, p = { $p }).
the-readings-state-no-uncertainty-of-their = The readings state no uncertainty of their own: their scatter is estimated from the residuals, and only their replicates test the model.
the-readings-state-no-uncertainty-of-their-2 = The readings state no uncertainty of their own: their scatter is estimated from the residuals, so these readings alone cannot test the model.
no-degrees-of-freedom-the-readings-just = No degrees of freedom: the readings just determine the parameters, and nothing checks them.
the-readings-of-scatter-no-more-than = The readings of `{ $sensor }` scatter no more than their last digit shows: u is that of rounding to { $step }.
one-linear-step-is-not-enough-gauss = One linear step is not enough: Gauss-Newton would go on by more than 0.1 u in { $what }. Fit without `--linear`.
converged = converged
did-not-converge = did not converge
the-linear-estimates-one-step-from-the = The linear estimates (one step from the reference point) are the same within 0.1 u.
the-linear-estimates-one-step-from-the-2 = The linear estimates (one step from the reference point) differ by more than 0.1 u (exact minus linear): { $differ }.
gauss-newton-after = Gauss-Newton { $word } after { $steps }{ $why }.{ $linear }
no-reading-responds-to-at-the-reference-2 = No reading responds to { $moved } at the reference point, where all that they are multiplied by is zero: the fit started beside it.
held-where-the-iteration-began-since-the-2 = Held where the iteration began, since the exact model determines them too weakly beyond it: { $held }.
u-holds-only-for-as-held-another-2 = U holds only for `{ $held }` as held: another value of it, { $by } away, changes { $shifts }.
from-the-fit-estimates-rank-of-freedom = From { $from } the fit estimates { $parameters } (rank { $rank }, { $dof }).
at-every-angle-is-known-to-arcsec = At { $level }, every angle is known to { $high } arcsec.
at-the-angles-are-known-to-between = At { $level }, the angles are known to between { $low } arcsec (`{ $best }`) and { $high } arcsec (`{ $worst }`).
fit-answer-for = { $sd } for `{ $sensor }`
residual-standard-deviation = Residual standard deviation: { $scatter }.
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
a-corrected-input-points-along-the-sensors = A corrected input points along the sensors' own axes. On the mounting face (the frame after the last joint) these are turned by { $tilts }; a rate or force known there has this component along them:

# report/html/fit_estimates.rs
angle = angle
coefficient = coefficient
not-estimable = not estimable
interval-to = , interval { $a } to { $b }
u-combined-standard-uncertainty-k-u-expanded = u: combined standard uncertainty; { $expanded } = k u: expanded uncertainty, k from Student's t with ν effective degrees of freedom.
estimates = Estimates
not-estimable-from-these-readings = Not estimable from these readings
only-determined = only { $only } { $n ->
    [one] is
   *[other] are
} determined
the-parameters-can-move-along-and-no = The parameters can move along `{ $text }` and no reading changes; { $instead }.
what-would-separate-it-a-further-reading = What would separate it: a further reading at { $keys }.
fit-estimates-but = But { $nowhere }.
no-position-of-this-bench-would-separate = No position of this bench would separate it: it takes another bench, or a known value.
determined-instead = determined instead
where-the-uncertainty-comes-from = Where the uncertainty comes from
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
residuals-of-before-bands-of-two-standard = Residuals of { $id } before bands of two standard deviations. { $beyond }{ $thinned }
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
gravity-g = gravity { $gravity_g } g
site-latitude-earth-rate-deg-h = Site: latitude { $latitude_deg }°, Earth rate { $earth_rate_deg_h } deg/h, { $said }.
no-site-no-earth-rate-and-gravity = No site: no Earth rate, and gravity is 1 g.
fit-readings-warning = Warning: { $warning }.
linear-rows-are-exact-derivatives-at-the = Linear: rows are exact derivatives at the reference point, and one step is taken from it.
exact-rows-are-exact-derivatives-iterated-to = Exact: rows are exact derivatives, iterated to the solution.
uncertainties-of-the-readings-are-as-stated = Uncertainties of the readings are as stated.
readings-of-one-sensor-scatter-alike-and = Readings of one sensor scatter alike and independently; how much, their residuals say.
entered-as-rows-of-their-own = { $prior } entered as rows of their own.
known = known
exact = exact
what-was-assumed = What was assumed
detectable = detectable
redundancy-the-share-of-a-fault-that = Redundancy: the share of a fault that shows in the reading's own residual. Detectable: the smallest fault that a test at 0.1 % finds with 80 % power. Marked: studentized beyond { $limit }.
the-first-of-are-listed-the-json = The first { $listed } of { $n } are listed; the JSON report has all.
readings = Readings

# report/html/checks_page.rs
lack-of-fit-the-model-leaves-more = Lack of fit: the model leaves more than replicates scatter (p = { $p }).
suspicious-see-the-checks = Suspicious: { $n ->
    [one] reading
   *[other] readings
} { $numbers }. See the checks.
the-robust-estimator-did-not-settle = The robust estimator ({ $method }) did not settle.
checks = Checks
test = test
statistic = statistic
lack-of-fit = lack of fit
f-with-and = F = { $f } with { $between_dof } and { $pure_error_dof } ν
runs-of = runs of `{ $sensor }`
runs-expected = { $runs } runs, { $expected } expected
normality = normality
suspicious-reading = suspicious reading
shift = shift
shift-how-far-the-reading-is-off = Shift: how far the reading is off what the others say. p: over all { $tested } readings (Sidak).
weakest-reading = weakest reading
effect = effect
change-without-suspects = change without suspects
external-reliability = External reliability
effect-what-the-smallest-detectable-fault-of = Effect: what the smallest detectable fault of the reading named would do to the parameter, undetected.
constraints-and-weights = Constraints and weights
constraint = constraint
side = side
cost-in-chi-square = cost in chi-square
no-reading-lost-more-than-half-of = No reading lost more than half of its weight.
less-than-half-of-their-weight-readings = Less than half of their weight: readings { $low }.
robust-estimator-of-reweighting = Robust estimator: { $method }, { $steps } of reweighting. { $down }
checks-page-interval = interval ({ $level })
shortest = shortest
first-order = first order
of-trials-seed = { $trials } of { $asked } trials, seed { $seed }.
marked-the-first-order-is-not-good = { $trials } Marked: the first order is not good to two digits of the uncertainty.

# report/html/conformity_page.rs
conformity = Conformity
lower-limit = lower limit
upper-limit = upper limit
probability = probability
outcome = outcome
probability-that-the-quantity-is-inside-its = Probability: that the quantity is inside its limits, by Student's t about the estimate (JCGM 106, 7.3).

# report/html/scatter_page.rs
what-scatters = What scatters
sources-of-scatter = Sources of scatter
sd-standard-deviation-of-one-deviation-a = sd: standard deviation of one deviation. A source is stated by the campaign or estimated from these readings (restricted maximum likelihood); each is a line of every budget.

# report/plot/normal.rs
normal-quantile = normal quantile
studentized-residual = studentized residual

# report/plot/values.rs
estimate-and-expanded-uncertainty = estimate and expanded uncertainty

# report/plot/bars.rs
bars-type = { $name } (Type { $type_b })

# report/html/compare_page.rs
least-squares-beside-the-published-closed-forms = Least squares beside the published closed forms
comparison-with-the-published-closed-forms = Comparison with the published closed forms
group-by-group-and-without-the-earth = Group by group and without the Earth rate, which the formulas ignore, they agree with least squares to { $difference } of the value: they are its square special case.
group-by-group-and-without-the-earth-2 = Group by group and without the Earth rate, which the formulas ignore, they differ from least squares by up to { $difference } of the value: these positions are not their square case.
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
what-seems-to-have-happened = what seems to have happened
misprints-found = Misprints found

# report/compare_table.rs
tumble-published-closed-forms-on = tumble { $tumble }: published closed forms on { $bench }
printed-mean = printed mean
closed-form-and-least-squares-without-earth = closed form and least squares without Earth rate differ by up to { $difference } of the value: these positions are not the square case of the formulas, which use some of the readings or weigh them otherwise.
closed-form-and-least-squares-without-earth-2 = closed form and least squares without Earth rate differ by at most { $difference } of the value: per group the formulas are the square special case. With the Earth rate in every row least squares moves by the difference of the last two columns; the closed forms ignore it.
closed-form-and-least-squares-differ-by = closed form and least squares differ by at most { $difference } of the value.
misprints-that-this-comparison-finds = misprints that this comparison finds:
printed-computed = printed { $printed }, computed { $computed }:

# report/conformity.rs
conformity-2 = conformity
lower = lower
upper = upper
conformity-conformity = conformity: { $outcome }; { $rule }

# report/site.rs
site-warning = warning: { $warning }
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
the-readings-scatter-no-more-than-without = the readings scatter no more than without it: estimated as zero; u and dof do not rely on its being zero
the-readings-scatter-no-more-than-without-2 = the readings scatter no more than without it: estimated as zero
no-reading-feels-it-here = no reading feels it here
these-readings-cannot-tell-it-from-their = these readings cannot tell it from { $others }: their sum is used; repeated readings at one level would separate them
no-degrees-of-freedom-are-left-to = no degrees of freedom are left to estimate it
in-each-reading-as-stated = in each reading as stated

# report/separation.rs
beyond-this-point-readings-respond-to-it = beyond this point readings respond to it, through what is zero here or hardly told from zero: state a value, a prior or a start
no-position-of-this-bench-would-separate-2 = no position of this bench would separate it
hides-in-and = { $last } hides in { $join } and { $before }

# report/fit_checks.rs
f-with-and-degrees-of-freedom-p = F = { $f } with { $between_dof } and { $pure_error_dof } degrees of freedom, p = { $p }
lack-of-fit-the-model-leaves-more-2 = LACK OF FIT: the model leaves more than replicates scatter ({ $numbers }); try `tumble diagnose`
replicates-scatter-as-much-as-the-model = replicates scatter as much as the model leaves ({ $numbers })
residuals-of-have-too-runs-of-one = residuals of { $sensor } have too { $word } runs of one sign ({ $runs } for { $expected } expected, p = { $p }): something drifts or alternates
residuals-are-not-normal-shapiro-francia-w = residuals are not normal (Shapiro-Francia W' = { $w }, p = { $p })
suspicious-reading-of-is-off-what-the = SUSPICIOUS: reading { $index } of { $sensor } is { $shift } off what the others say (w = { $w }, p = { $p } over all { $tested } readings)

# report/fit_constraints.rs
no-values-meet-constraints-together-none-was = no values meet constraints { $named } together: none was applied
the-constraints-were-not-applied-the-readings = the constraints were not applied: the readings leave parameters free, or the solver gave up
constraint-costs-in-chi-square = constraint { $index } ({ $text }) costs { $cost } in chi-square
rejected-the-readings-contradict-the-bounds-p = REJECTED: the readings contradict the bounds (p = { $p })
no-bound-is-active-the-estimate-is = no bound is active: the estimate is the free one

# report/monte_carlo.rs
the-first-order-does-not-describe-its = the first order does not describe { $id }: its { $level } % interval ends up to { $sd } u elsewhere; use the Monte Carlo interval

# fit/remarks.rs
all-values-of-lie-within-degrees-and = all values of { $name } lie within 6.3 degrees and would go round the circle as radians: are they radians?
condition-the-readings-hardly-tell-some-parameters = condition { $condition }: the readings hardly tell some parameters apart; look at the units of the inputs and at the correlations
belongs-to-the-bench-and-stays-there = { $others } { $n ->
    [one] belongs to the bench and stays there
   *[other] belong to the bench and stay there
}.

# campaign/identity.rs
identity-unit = Unit
identity-serial = serial { $serial }
identity-date = Date
identity-place = Place
identity-operator = Operator
identity-instrument = Instrument
identity-certificate = certificate
identity-valid-to = valid to
identity-traceable-to = traceable to
identity-procedure = Procedure
identity-environment = Environment
identity-note = Note

# sources of scatter
what-scatters-2 = what scatters
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
per-reading = reading
per-position = position
per-campaign = campaign
source-note = { $source }: { $note }
source-note-sentence = `{ $source }`: { $note }.
these-readings-cannot-tell-it-from-the-rest = these readings cannot tell it from what else scatters: their sum is used; repeated readings at one level would separate them
joined-sources = { $before } and { $other }

# words of several reports
correction-error-in = { $error } { $unit } in { $id }
robust-estimate-settled = robust estimate ({ $method }) settled after { $steps } steps
robust-estimate-did-not-settle = robust estimate ({ $method }) did NOT settle after { $steps } steps
no-loud = NO
runs-few = few
runs-many = many
joined-by-and = { " and " }
state-and-meaning = { $state }{ $between }. { $meaning }
from-to = { $a } to { $b }
colon-why = : { $why }
conformity-passes = Pass, by { $rule }.
conformity-fails = Fail, by { $rule }.
conformity-is-undecided = Undecided, by { $rule }.
tone-plain = Note
tone-good = In order
tone-caution = Caution
tone-bad = Rejected

# the certificate
angles-and-coefficients = Angles and coefficients
dcc-model = Model: { $models }.
dcc-least-squares = Least squares ({ $estimator }) from { $readings } readings with { $dof } degrees of freedom.
dcc-known = Known: { $known }.
dcc-assumed-zero = Assumed zero: { $assumed_zero }.
dcc-not-estimable = Not estimable and therefore not given: { $text }.
dcc-robust = Robust estimator: { $method }.
dcc-global-test-failed = Global chi-square test failed, p = { $p }.
dcc-global-test-passed = Global chi-square test passed, p = { $p }.
dcc-what-scatters = Standard deviations of the deviations that the uncertainties take into account.
dcc-estimated-values = estimated ({ $levels } values)
dcc-stated-values = stated ({ $levels } values)
dcc-standard-uncertainty = standard uncertainty { $u }
dcc-covariance = Covariance of the estimates
dcc-jointly = all estimates jointly

# why Gauss-Newton ended
distribution-arcsine = arcsine

# why Gauss-Newton ended
stop-settled = the last step no longer matters
stop-unsettled = the scales inside the last step did not settle
stop-limit = the steps did not end
stop-stalled = steps stay long while the fit no longer becomes better: the readings hardly determine some direction
stop-no-descent = no part of the last step makes the fit better
stop-out-of-range = numbers leave the range of a double

# report/fit_table.rs

# report/fit_checks_table.rs

# report/html/fit_answer.rs

# report/html/fit_correction.rs

# report/html/checks_page.rs

# report/html/conformity_page.rs

# report/scatter.rs

# report/fit_checks.rs

# report/fit_constraints.rs

# report/changes.rs
before = before
after = after
difference = difference
per-day = per day
changed = CHANGED
u-expanded-uncertainty-of-the-difference-e = U: expanded uncertainty of the difference ({ $level } %); E_n = difference/U; CHANGED: significant with all tested together (Holm)
the-unit-has-changed = the unit has CHANGED
no-change-beyond-the-uncertainties = no change beyond the uncertainties
f-with-and-degrees-of-freedom = F = { $f } with { $dof } and { $scatter_dof } degrees of freedom
chi-square-with-degrees-of-freedom = chi-square { $statistic } with { $dof } degrees of freedom
all-parameters-together-p = all parameters together: { $test }, p = { $p }: { $verdict }
shared-inputs-none-both-count-as-independent = shared inputs: none; both count as independent
shared-inputs-not-counted-twice = shared inputs, not counted twice: { $shared }
combined-estimate-u-holds-only-where-both = combined estimate; u holds only where both agree, that is, where the Birge ratio is not well above 1
birge-ratio = Birge ratio
changes-only = only { $which }: { $ids }
tumble-history-of-calibrations = tumble { $tumble }: history of { $calibrations } calibrations
date = date
serial = serial
file = file
leaves-its-limits-about = leaves its limits about { $day }
drifts = drifts
too-few-dates = too few dates
first = first
last = last
per-year = per year

# report/html/changes_page.rs
two-calibrations-of-one-unit = Two calibrations of one unit
what-changed-by-more-than-the-uncertainties = What changed, by more than the uncertainties allow
title-before = Before
title-after = After
the-answer = The answer
the-unit-has-changed-all-parameters-together = The unit has changed: all parameters together differ with p = { $p }, though no single one is beyond doubt.
no-quantity-changed-by-more-than-the = No quantity changed by more than the uncertainties of the two calibrations allow.
changed-by-more-than-the-uncertainties-allow = Changed by more than the uncertainties allow: { $ids }.
no-input-is-shared-both-calibrations-count = No input is shared: both calibrations count as independent.
shared-by-both-calibrations-and-therefore-not = Shared by both calibrations, and therefore not counted twice: { $shared }.
u-expanded-uncertainty-of-the-difference-e-2 = U: expanded uncertainty of the difference; E_n = difference/U. Marked: significant with all quantities tested together (Holm).
difference-over-u-bars-u = difference over U (bars: U)
differences-of-the-two-calibrations-over-their = Differences of the two calibrations over their expanded uncertainties
each-difference-over-its-expanded-uncertainty-a = Each difference over its expanded uncertainty: a bar that misses zero is a change.
the-weighted-mean-of-both-its-u = The weighted mean of both; its u holds where both agree, that is, where the Birge ratio is not well above 1.
combined-estimate = Combined estimate
history-of-calibrations = History of { $calibrations } calibrations
each-quantity-over-time-with-its-trend = Each quantity over time, with its trend and its limits
no-quantity-drifts-by-more-than-its = No quantity drifts by more than its calibrations scatter.
drift-beyond-the-scatter-of-the-calibrations = Drift beyond the scatter of the calibrations: { $drifts }.
leaves-its-limits-about-2 = `{ $id }` leaves its limits about { $day }.
over-time = { $id } over time
with-bars-of-u-dashed-limits-line = `{ $id }` with bars of 2 u; dashed: limits; line: trend where it is significant.
over-time-2 = Over time

# report/plot/history.rs
year = year

# compare/misprints.rs
the-tables-own-readings-give-another-value = the table's own readings give another value
printed-with-the-opposite-sign-to-the = printed with the opposite sign to the table and the formulas
printed-with-the-opposite-sign-to-the-2 = printed with the opposite sign to the table and the formulas, and off in the last digit
this-is-the-value-of-group-not = this is the value of group { $value }, not the mean
not-the-mean-of-the-table = not the mean of the table
mean-of = mean of { $id }
in-the-printed-equation = { $id } in the printed equation
the-printed-equation-has-the-printed-chain = the printed equation has { $id }, the printed chain of rotations has not
coefficient-of-in-the-printed-equation = coefficient of { $id } in the printed equation
the-chain-of-rotations-gives-the-opposite = the chain of rotations gives the opposite sign
the-chain-of-rotations-gives-another-value = the chain of rotations gives another value
two-calibrations = tumble { $tumble }: two calibrations of one unit
calibrated-before = before: { $who }
calibrated-after = { "after:  " }{ $who }
misprint-of = { $what }:
quantity-at = { $id } at { $value }

# fit/azimuth.rs
azimuth-is-any = both components may be zero, so every direction is possible: the interval is the whole circle, and u is that of an angle of which nothing is known
azimuth-interval = { $level } % interval { $low } to { $high }{ $unit }: the components are near zero, where it is not value - U to value + U

# correction
left-out-not-estimable = not estimable: { $names }
its-line-does-not-bind = its line does not bind
its-line-has-no-slope-at-zero-input = its line has no slope at zero input
its-line-follows-no-rate = its line follows no rate and no specific force to first order
dcc-as-found = as found, before adjustment
dcc-as-left = as left, after adjustment
dcc-state-of-item = State of the item
dcc-title-and-state = { $title }: { $state }
dcc-probability = Probability of conformity { $probability }.
dcc-correction = inputs = matrix * (readings - bias), to first order, in frame { $frame }.
dcc-row = Row of the matrix for { $input }
angles-at-bounds = Upright lines: active bounds; there the bar is what the bounds leave of the interval.
source-weights = estimated weights (Kenward-Roger)
