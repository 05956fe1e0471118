"""Types of the reports: their keys as attributes, each with its unit. Written by scripts/reports.py from the JSON Schemas."""

# ruff: noqa: E501
from __future__ import annotations

from typing import Any, Literal, TypeAlias

from ._report import Node, Report

__all__ = [
    "Agreement",
    "AgreementReport",
    "AliasReport",
    "AlikeReport",
    "ArcsecReport",
    "AssertedReport",
    "BatchReport",
    "BetweenReport",
    "BinReport",
    "BinsReport",
    "BudgetReport",
    "CalibratedReport",
    "CarriedReport",
    "CellReport",
    "ChanceReport",
    "ChangeOfReport",
    "ChangeReport",
    "ChannelReport",
    "ChecksReport",
    "CircleReport",
    "CoefficientReport",
    "CombinationReport",
    "CombinationValueReport",
    "CompareCalibrationsReport",
    "CompareHistoryReport",
    "CompareReport",
    "ComparisonReport",
    "ConditionalReport",
    "Conformity",
    "ConformityCounts",
    "ConformityReport",
    "ConstraintReport",
    "ConstraintState",
    "ConstraintsReport",
    "ConstraintsStatus",
    "ConvergenceReport",
    "CorrectedSensorFile",
    "CorrectionFile",
    "CorrectionParametersFile",
    "CorrelationReport",
    "CovarianceReport",
    "Decision",
    "DerivedReport",
    "DetectorReport",
    "DeviationReport",
    "DeviationsReport",
    "DeviceCounts",
    "DiagnoseNoiseReport",
    "DiagnoseReport",
    "DiagnoseVerdict",
    "DiscriminationReport",
    "Distribution",
    "DistributionReport",
    "DrawnReport",
    "EffectReport",
    "Effort",
    "Ending",
    "EquationsReport",
    "ErrorReport",
    "Estimated",
    "Estimator",
    "Evaluation",
    "Explanation",
    "ExternalReport",
    "FarReport",
    "Fate",
    "FindReport",
    "FitReport",
    "FitState",
    "FitSummary",
    "FitSuspectReport",
    "FollowsReport",
    "ForesightReport",
    "GapReport",
    "GapStepReport",
    "GapsReport",
    "GoalReport",
    "GravityBasis",
    "GravityReport",
    "GroupReport",
    "GuideHeld",
    "GuideReport",
    "GuideVerdict",
    "Held",
    "HeldMean",
    "Holding",
    "HoldoutReport",
    "Identity",
    "ImprovedReport",
    "Input",
    "InputFile",
    "Instrument",
    "IterationReport",
    "JointReport",
    "JudgementReport",
    "JumpKind",
    "JumpReport",
    "Kind",
    "KnownReport",
    "LackOfFitReport",
    "LackingReport",
    "Lacks",
    "LagReport",
    "LegFile",
    "LegsFile",
    "LimitedReport",
    "LotReport",
    "MeansReport",
    "MisprintReport",
    "Mistake",
    "MistakeKind",
    "MonteCarloReport",
    "MountingFile",
    "MovesReport",
    "Named",
    "NavigateDiagnoseNoiseReport",
    "NavigateDiagnoseReport",
    "NavigateDiagnoseVerdict",
    "NavigateReport",
    "NavigationAliasReport",
    "NavigationCellReport",
    "NavigationEffectReport",
    "NavigationGapStepReport",
    "NavigationSuspectReport",
    "NearReport",
    "Newest",
    "Next",
    "NoiseChangeReport",
    "NoiseColumnReport",
    "NoiseFrom",
    "NoiseReport",
    "NoiseScatterReport",
    "NoiseSource",
    "NoisyDeviceReport",
    "NormalityReport",
    "NotEstimableReport",
    "NotInOrderReport",
    "OscillationFile",
    "OutlyingReport",
    "ParameterReport",
    "PassedOverReport",
    "PeriodsReport",
    "PlaceReport",
    "PlanReport",
    "PlannedPositionReport",
    "PlannedReadingReport",
    "PointReport",
    "PointSource",
    "PredictedDerivedReport",
    "PredictedReport",
    "Progress",
    "ProspectReport",
    "QuantityFile",
    "QuantityReport",
    "QuantityWithUnit",
    "RatioReport",
    "ReadingReport",
    "ReasonReport",
    "RecordReport",
    "RecordSensorReport",
    "ReduceReport",
    "RefinedReport",
    "RejectedReport",
    "ReportKind",
    "Residual",
    "ResidualReport",
    "ResultReport",
    "RobustMethod",
    "RobustReport",
    "RuleReport",
    "RunReport",
    "RunsReport",
    "ScatterReport",
    "ScenarioReport",
    "SegmentMeanReport",
    "SegmentReport",
    "SensorGapReport",
    "SensorNoiseReport",
    "SensorSizeReport",
    "SeparationReport",
    "Shape",
    "SharedReport",
    "Side",
    "SiteReport",
    "SnoopingReport",
    "State",
    "StaticFile",
    "StepReport",
    "Stop",
    "SummaryReport",
    "SuspectReport",
    "Suspected",
    "SwingFile",
    "Term",
    "ThroughTiltsReport",
    "TogetherReport",
    "TrendReport",
    "UnexplainedNavigationReport",
    "UnexplainedReport",
    "UnitUnderTest",
    "ValidityFile",
    "VarianceFrom",
    "Verdict",
    "Why",
    "Without",
    "WorkReport",
]


class BetweenReport(Node):
    """Between-device scatter against the uncertainty from each device's own readings."""

    dof: float
    """Degrees of freedom of the numerator."""
    f: float
    """Variance between devices over that of the readings, a pure number."""
    p: float
    """Probability of a larger ratio if all devices were alike."""
    sd_of_devices: float
    """Standard deviation of the devices' true values that explains the excess scatter, in the quantity's unit."""
    significant: bool | None
    """Do devices differ by more than their readings scatter (p below 1 %)?"""
    u: float
    """Root mean square of the Type A standard uncertainties."""
    u_dof: float | None
    """Degrees of freedom of the denominator; null for infinite."""

    _keys = frozenset(["dof", "f", "p", "sd_of_devices", "significant", "u", "u_dof"])


class ChanceReport(Node):
    """A test of every device."""

    beyond: int
    """In how many it finds something at the level over all devices together."""
    expected: float
    """In how many it finds something by chance alone, a pure number: one minus the level, times those tested."""
    found: int
    """Devices in which it found something."""
    tested: int
    """Devices that could be tested."""

    _keys = frozenset(["beyond", "expected", "found", "tested"])

Conformity: TypeAlias = Literal["pass", "undecided", "fail"]
"""What a decision rule says."""


class ConformityCounts(Node):
    """Devices by conformity."""

    decision: Decision
    """`simple`, `guard-u` or `risk`."""
    fail: int
    """Outside some limit."""
    pass_: int
    """Inside every limit."""
    undecided: int
    """Left open by the uncertainty."""

    _keys = frozenset(["decision", "fail", "pass", "undecided"])

Decision: TypeAlias = Literal["simple", "guard-u", "risk"]
"""How conformity is decided (JCGM 106:2012, ISO/IEC 17025 7.8.6)."""


class DeviceCounts(Node):
    """Devices by what became of them."""

    accepted: int
    """Determined, and the global test passed where there is one."""
    all: int
    """All."""
    common_schedule: int
    """Fitted by the factorisation of a common schedule."""
    malformed: int
    """Readings that are no readings of this campaign."""
    own_fit: int
    """Fitted by themselves."""
    rejected: int
    """A rank defect, a failed global test, lack of fit, no convergence."""
    suspicious: int
    """With suspicious readings."""

    _keys = frozenset(["accepted", "all", "common_schedule", "malformed", "own_fit", "rejected", "suspicious"])


class DistributionReport(Node):
    """A quantity over the accepted devices, in `unit`."""

    devices: int
    """Devices that have a value."""
    id: str
    """Name."""
    least: float
    """Least value, in `unit`."""
    limits: list[float | None] | None
    """Limits, in `unit`; null for none."""
    mean: float
    """Mean of the devices that do not stand apart (`outlying`), in `unit`."""
    median: float
    """Median, in `unit`."""
    most: float
    """Largest value, in `unit`."""
    q05: float
    """Value below which 5 % of the devices are, in `unit`."""
    q95: float
    """Value below which 95 % of the devices are, in `unit`."""
    scattering: BetweenReport | None
    """Do the devices that do not stand apart differ more than they are measured? Null without uncertainties."""
    sd: float | None
    """Standard deviation between them, in `unit`."""
    u: float | None
    """Root mean square of the devices' standard uncertainties."""
    unit: str
    """Unit (`rad` for tilts)."""

    _keys = frozenset(["devices", "id", "least", "limits", "mean", "median", "most", "q05", "q95", "scattering", "sd", "u", "unit"])

Estimator: TypeAlias = Literal["exact", "linear"]
"""How far to go from the reference point."""


class Input(Node):
    """An input file."""

    name: str
    """Its name, as the user gave it."""
    sha256: str
    """SHA-256 of its bytes, in hexadecimal."""

    _keys = frozenset(["name", "sha256"])


class LotReport(Node):
    """A lot or a date."""

    control: dict[str, float] | None
    """Control limits of the lot's mean, as their distance from the mean of all devices: three standard deviations of a mean of so many
    devices, from the scatter within lots (lots of one device: from the moving range), in the quantity's unit."""
    devices: dict[str, int]
    """Accepted devices, for each quantity that some device has."""
    mean: dict[str, float]
    """Mean of each quantity."""
    name: str
    """Its name."""
    sd: dict[str, float | None]
    """Standard deviation of each quantity within the lot; null for one device."""

    _keys = frozenset(["control", "devices", "mean", "name", "sd"])


class NoisyDeviceReport(Node):
    """An accepted device whose residuals scatter more than those of the others."""

    device: str
    """The device."""
    dof: float
    """Degrees of freedom of the device."""
    f: float
    """The variance of the one over that of the others, a pure number."""
    p: float
    """Probability of a larger ratio by chance, for this device alone."""
    pooled_dof: float
    """Degrees of freedom of the others."""
    pooled_sd: float
    """That of the devices with no more scatter, pooled, in the sensor's unit."""
    residual_sd: float
    """Its residual standard deviation, in the sensor's unit."""

    _keys = frozenset(["device", "dof", "f", "p", "pooled_dof", "pooled_sd", "residual_sd"])


class NotInOrderReport(Node):
    """A device that is not accepted, or outside a limit."""

    conformity: Conformity | None
    """The worst outcome of its limits; null without limits."""
    device: str
    """The device."""
    verdict: Verdict
    """`rejected`, `malformed`, or `accepted` where only a limit is not kept."""
    why: str
    """What is wrong, in words; empty where only a limit is not kept."""

    _keys = frozenset(["conformity", "device", "verdict", "why"])


class OutlyingReport(Node):
    """An outlying device."""

    device: str
    """The device."""
    id: str
    """The quantity."""
    value: float
    """Its value, in the quantity's unit."""
    z: float
    """Distance from the median in robust standard deviations, `(x - median) / (1.4826 MAD)`."""

    _keys = frozenset(["device", "id", "value", "z"])

ReportKind: TypeAlias = Literal["fit", "batch", "compare", "compare-calibrations", "compare-history", "diagnose", "plan", "guide", "navigate", "navigate-diagnose", "noise", "reduce"]
"""What kind of report it is."""

Verdict: TypeAlias = Literal["accepted", "rejected", "malformed"]
"""Is the answer usable?"""


class BatchReport(Report):
    """What a table of many devices comes to."""

    bench: str
    """The bench."""
    by: str
    """The column that identifies the device; `file` if each file is a device."""
    chance: dict[str, ChanceReport] | None
    """For each test of the devices, by the reason that it gives, what chance alone finds."""
    conformity: ConformityCounts | None
    """Conformity with the limits; null without limits."""
    devices: DeviceCounts
    """Devices, and how many of them are what."""
    estimator: Estimator
    """`exact` or `linear`."""
    inputs: list[Input] | None
    """Files that it was made from, with digests."""
    level: float
    """Coverage probability of expanded uncertainties."""
    lots: list[LotReport] | None
    """Lots or dates in the order in which they were met; empty where no column has them."""
    model: dict[str, str]
    """Model line of each sensor."""
    noisy: list[NoisyDeviceReport] | None
    """Accepted devices whose residuals scatter more than those of the others (1 % over all devices), the noisiest first, at most 50."""
    not_in_order: list[NotInOrderReport] | None
    """Devices that are not accepted or lie outside a limit, the worst first, at most 100: those without an answer, those that a test rejects
    (the least probable first), those outside a limit, those that their limits leave undecided."""
    outlying: list[OutlyingReport]
    """Outlying devices, the farthest first, at most 50."""
    quantities: list[DistributionReport]
    """Every estimated parameter and derived quantity over the accepted devices."""
    reasons: dict[str, int] | None
    """Devices by what is wrong with them, or suspicious; a device may have several reasons."""
    report: ReportKind
    """Always `batch`."""
    tumble: str
    """Version of the program that wrote it."""

    _keys = frozenset(["bench", "by", "chance", "conformity", "devices", "estimator", "inputs", "level", "lots", "model", "noisy", "not_in_order", "outlying", "quantities", "reasons", "report", "tumble"])


class CalibratedReport(Node):
    """A calibration that was compared."""

    bench: str
    """Its bench."""
    date: str | None
    """Its date (`YYYY-MM-DD`)."""
    file: str
    """Its file."""
    serial: str | None
    """Serial number of the unit."""

    _keys = frozenset(["bench", "date", "file", "serial"])


class ChangeOfReport(Node):
    """How one quantity changed."""

    U: float | None
    """Its expanded uncertainty, in `unit`."""
    after: float
    """Estimate after, in `unit`."""
    before: float
    """Estimate before, in `unit`."""
    birge: float | None
    """Birge ratio: well above 1 the two do not agree, and the mean's uncertainty is too small by it."""
    combined: float | None
    """Weighted mean of both, in `unit`."""
    difference: float
    """After minus before, in `unit`."""
    dof: float | None
    """Its effective degrees of freedom; null for infinite."""
    e_n: float | None
    """`difference / U`, a pure number."""
    id: str
    """Its name."""
    p: float | None
    """Probability of a larger difference by chance."""
    per_day: float | None
    """Difference, in `unit` per day."""
    significant: bool | None
    """Is the change significant, all quantities tested together (Holm)?"""
    u: float | None
    """Standard uncertainty of the difference, shared inputs taken out, in `unit`."""
    u_after: float | None
    """Its standard uncertainty, in `unit`."""
    u_before: float | None
    """Its standard uncertainty, in `unit`."""
    u_combined: float | None
    """Standard uncertainty of the mean, as it is where both agree, in `unit`."""
    unit: str
    """Unit of all numbers but ratios."""

    _keys = frozenset(["U", "after", "before", "birge", "combined", "difference", "dof", "e_n", "id", "p", "per_day", "significant", "u", "u_after", "u_before", "u_combined", "unit"])


class TogetherReport(Node):
    """The test of all changes together."""

    dof: int
    """Degrees of freedom: how many quantities."""
    p: float
    """Probability of a larger one by chance."""
    scatter_dof: float | None
    """Degrees of freedom of the scatter; null where it is known (chi-square, else F)."""
    significant: bool
    """Is it below one minus the level?"""
    statistic: float
    """`d' C^-1 d` of the differences, a pure number."""

    _keys = frozenset(["dof", "p", "scatter_dof", "significant", "statistic"])


class CompareCalibrationsReport(Report):
    """What `tumble compare A B --json` writes."""

    after: CalibratedReport
    """The later one."""
    before: CalibratedReport
    """The earlier calibration."""
    changes: list[ChangeOfReport]
    """Each quantity that both have (angles in arcsec)."""
    level: float
    """Coverage probability of expanded uncertainties."""
    only_after: list[str]
    """Quantities that only the later one has."""
    only_before: list[str]
    """Quantities that only the earlier one has."""
    report: ReportKind
    """Always `compare-calibrations`."""
    shared: list[str]
    """Known inputs that both share: they moved both results alike and do not count twice."""
    together: TogetherReport | None
    """All changes of parameters together."""
    tumble: str
    """Version of the program that wrote it."""

    _keys = frozenset(["after", "before", "changes", "level", "only_after", "only_before", "report", "shared", "together", "tumble"])


class TrendReport(Node):
    """A quantity over time."""

    birge: float | None
    """Birge ratio of the points about the line."""
    id: str
    """Its name."""
    leaves: float | None
    """Day on which the line leaves its limits, in days from 1970-01-01; before the last calibration where it has left them. Null where it does
    not, or where no slope is significant."""
    limits: list[float] | None
    """Limits, where the last calibration states them."""
    per_day: float | None
    """Slope per day of a straight line, in `unit` per day; null with fewer than three days."""
    points: list[list[float | float | None]]
    """Each calibration's day (from 1970-01-01), value and standard uncertainty."""
    significant: bool | None
    """Is the slope significant?"""
    u_per_day: float | None
    """Its standard uncertainty, in `unit` per day."""
    unit: str
    """Unit of values."""

    _keys = frozenset(["birge", "id", "leaves", "limits", "per_day", "points", "significant", "u_per_day", "unit"])


class CompareHistoryReport(Report):
    """What `tumble compare A B C ... --json` writes."""

    calibrations: list[CalibratedReport]
    """The calibrations, by date."""
    level: float
    """Coverage probability."""
    report: ReportKind
    """Always `compare-history`."""
    trends: list[TrendReport]
    """Each quantity over time (angles in arcsec)."""
    tumble: str
    """Version of the program that wrote it."""

    _keys = frozenset(["calibrations", "level", "report", "trends", "tumble"])

Condition: TypeAlias = "float | dict[str, Any] | list[float] | str"


class GroupReport(Node):
    """One group of readings."""

    group: float | None
    """The rate or run, in the unit of its column; null for all readings."""
    quantities: list[QuantityReport]
    """Each quantity."""
    readings: int
    """How many readings."""

    _keys = frozenset(["group", "quantities", "readings"])


class Identity(Node):
    """The identity of a campaign; everything in it is text for people, except the environment's numbers."""

    date: str | None
    """Date of the measurement."""
    environment: dict[str, Condition] | None
    """Conditions, for example `"temperature_c": 23.1`."""
    instruments: list[Instrument] | None
    """Instruments and their traceability."""
    note: str | None
    """A remark."""
    operator: str | None
    """Who measured."""
    place: str | None
    """Place of the measurement."""
    procedure: str | None
    """The procedure that was followed."""
    unit: UnitUnderTest | None
    """The unit under test."""

    _keys = frozenset(["date", "environment", "instruments", "note", "operator", "place", "procedure", "unit"])


class Instrument(Node):
    """An instrument."""

    certificate: str | None
    """Number of its calibration certificate."""
    name: str
    """What it is."""
    traceable_to: str | None
    """What the certificate is traceable to."""
    valid_to: str | None
    """The day until which that is valid."""

    _keys = frozenset(["certificate", "name", "traceable_to", "valid_to"])


class MisprintReport(Node):
    """A disagreement between print and computation."""

    computed: float | None
    """As computed, in the unit of `printed`."""
    explanation: str
    """What seems to have happened."""
    printed: float | None
    """As printed (arcsec for angles)."""
    what: str
    """What is misprinted."""

    _keys = frozenset(["computed", "explanation", "printed", "what"])


class QuantityReport(Node):
    """One quantity of a group."""

    closed_form: float | None
    """By the published closed form, in `unit` (for all readings: the mean over the groups)."""
    id: str
    """Name."""
    least_squares: float | None
    """By least squares with the site's Earth rate, in `unit`."""
    printed: float | None
    """As printed, in `unit`."""
    unit: str
    """`arcsec` for angles, else the parameter's own unit."""
    without_earth_rate: float | None
    """By least squares without Earth rate, where the closed forms ignore it and the site has one (absent for all readings), in `unit`."""

    _keys = frozenset(["closed_form", "id", "least_squares", "printed", "unit", "without_earth_rate"])


class UnitUnderTest(Node):
    """The unit under test."""

    manufacturer: str | None
    """Manufacturer."""
    serial: str | None
    """Serial number."""
    type: str | None
    """Type or model."""

    _keys = frozenset(["manufacturer", "serial", "type"])


class CompareReport(Report):
    """What `tumble compare --json` writes."""

    all: GroupReport
    """All readings: mean of the closed forms, and one least-squares fit."""
    bench: str
    """Id of the bench."""
    group_title: str
    """What the groups are."""
    groups: list[GroupReport]
    """Each rate or run."""
    identity: Identity | None
    """The unit under test, when, where, by whom, with what."""
    inputs: list[Input] | None
    """The files that the report was made from, with the SHA-256 of their bytes."""
    largest_relative_difference: float | None
    """Largest relative difference between closed form and least squares on the same physics (without Earth rate where the closed forms ignore
    it); null if no closed form could be computed."""
    misprints: list[MisprintReport]
    """Where print and computation disagree."""
    printed: str | None
    """Title of the printed table, if this campaign is the published one."""
    report: ReportKind
    """Always `compare`."""
    source: str
    """Where the closed forms come from."""
    tumble: str
    """Version of the program that wrote it."""

    _keys = frozenset(["all", "bench", "group_title", "groups", "identity", "inputs", "largest_relative_difference", "misprints", "printed", "report", "source", "tumble"])


class AliasReport(Node):
    """Another effect that explains the same."""

    exact: bool
    """The same column exactly (true), or only a fit that is not significantly worse (false)."""
    excess: float
    """How much worse it fits, in variances of the noise."""
    name: str
    """Its name."""
    only_small_terms: bool
    """Is it seen only through small terms (it vanishes here but for small tilts, or the model has nearly all of it)?"""
    probability: float
    """Posterior probability that it is the effect."""
    regressor: str
    """Its regressor."""
    size: float
    """Largest value of its term here over what its inputs could make of it, a pure number."""
    together_with: str | None
    """A second effect that must then replace another one that was found."""
    visible: float
    """Share of its column that the model as given leaves, 0 to 1."""

    _keys = frozenset(["exact", "excess", "name", "only_small_terms", "probability", "regressor", "size", "together_with", "visible"])


class AssertedReport(Node):
    """A constraint of the campaign in a diagnosis."""

    index: int
    """Number in the file, from 1."""
    state: Held
    """`equality` (met exactly), `at-limit` (an inequality that holds the estimate back: taken as an equality), `inactive`, `left-out` (it
    contradicts others, or cannot be applied), `wrong` (a finding: taken away by the repair)."""
    text: str
    """The constraint as a line of text."""

    _keys = frozenset(["index", "state", "text"])


class CellReport(Node):
    """Mean residual at one state of the joints."""

    at: dict[str, float]
    """The state."""
    mean: float
    """Mean residual, in the sensor's unit."""
    readings: int
    """Readings there."""
    sensor: str
    """The sensor."""
    z: float
    """Its size in standard deviations."""

    _keys = frozenset(["at", "mean", "readings", "sensor", "z"])


class ChangeReport(Node):
    """A parameter before and after the repair."""

    after: float | None
    """After, in `unit`."""
    alias_half_width: float
    """How far the value would move at most if an alias were the effect, in `unit`."""
    alias_u: float
    """Standard deviation of the value over the explanations that remain, each with its probability (part of `u_after`), in `unit`."""
    before: float | None
    """Before, in `unit`."""
    change_in_u: float | None
    """After minus before, over the standard uncertainty after as named, a ratio."""
    id: str
    """Name."""
    remainder_u: float
    """Standard uncertainty from what is unexplained, beyond that of the noise (part of `u_after`), in `unit`."""
    shift: float | None
    """After minus before, in `unit`."""
    u_after: float | None
    """Standard uncertainty after, with what is not known about which alias it is, and what is unexplained, in `unit`."""
    u_after_as_named: float | None
    """Standard uncertainty after, if the effects are the ones named, in `unit`."""
    u_before: float | None
    """Standard uncertainty before, in `unit`."""
    unit: str
    """Unit of the numbers: `arcsec` for tilts."""

    _keys = frozenset(["after", "alias_half_width", "alias_u", "before", "change_in_u", "id", "remainder_u", "shift", "u_after", "u_after_as_named", "u_before", "unit"])


class EffectReport(Node):
    """A missing effect."""

    U: float | None
    """Its expanded uncertainty, in `unit`."""
    aliases: list[AliasReport]
    """What else it could be on this schedule."""
    arcsec: float | None
    """The value in arcseconds, for an angle."""
    coefficient: str
    """Name of the coefficient in the repaired model line; empty for a prior or a constraint that is wrong."""
    confirm: str
    """How to confirm it."""
    explains: float
    """Share of the residual sum of squares that it removes."""
    gap_after: GapReport | None
    """The gap with this effect and those before it in the model."""
    in_sensors: list[SensorSizeReport]
    """Its size in each sensor, where several have it; empty where one does, or all share it."""
    level: float
    """Coverage probability of the expanded uncertainty."""
    name: str
    """Name in the field's words."""
    p: float
    """Probability of evidence as strong by chance, among all that was tried."""
    probability: float
    """Posterior probability that it or one of its aliases is present."""
    probability_as_named: float
    """Posterior probability that it is the effect, rather than an alias."""
    regressor: str
    """The appended term without its coefficient."""
    sensor: str | None
    """The sensor; null for what is common to all."""
    separate_by: list[dict[str, float]]
    """Positions that would discriminate them, best first."""
    separate_never: list[str]
    """Aliases among them that no position of this bench discriminates."""
    separate_of: int
    """of the number that a position could discriminate in principle."""
    separate_tells: list[int]
    """How many aliases each of these positions discriminates,"""
    stated_u: float | None
    """Standard uncertainty that was stated for a known parameter or a prior which is found wrong, in `unit`; null for anything else."""
    t: float
    """Student's t (z where the noise is stated), the other effects given."""
    u: float | None
    """Its standard uncertainty, in `unit`."""
    unit: str
    """Unit; empty where the term does not determine it."""
    value: float | None
    """Coefficient, in `unit`; for a known parameter, a prior or a constraint its error; null where the repaired model does not determine it."""
    visible: float
    """Share of its column that the model as given leaves, 0 to 1: what it is seen by."""
    why: str
    """Why it happens."""

    _keys = frozenset(["U", "aliases", "arcsec", "coefficient", "confirm", "explains", "gap_after", "in_sensors", "level", "name", "p", "probability", "probability_as_named", "regressor", "sensor", "separate_by", "separate_never", "separate_of", "separate_tells", "stated_u", "t", "u", "unit", "value", "visible", "why"])


class GapReport(Node):
    """A gap."""

    chi_square: float
    """`sum (v/u)^2` with the noise floor, a pure number."""
    dof: int
    """Degrees of freedom."""
    max: float
    """Largest residual by size, in the first sensor's unit (of navigation errors: in standard uncertainties)."""
    p: float | None
    """Probability of a gap as large by chance; null where the noise is known from the residuals only."""
    rms: float | None
    """`sqrt(sum v^2 / dof)`; null without degrees of freedom. With sensors of several units it has none: see `sensors`."""

    _keys = frozenset(["chi_square", "dof", "max", "p", "rms"])


class GapStepReport(Node):
    """The gap with some effects in the model."""

    decision: str
    """What was decided here, and why."""
    gap: GapReport
    """The gap."""
    global_p: float | None
    """Probability of what is left by chance."""
    model: dict[str, str]
    """Each sensor's model line."""
    p: float | None
    """Its probability by chance among all that was tried."""
    strongest: str | None
    """The strongest further candidate."""
    t: float | None
    """Its t."""
    with_: list[str]
    """Effects in the model."""

    _keys = frozenset(["decision", "gap", "global_p", "model", "p", "strongest", "t", "with"])


class GapsReport(Node):
    """The gap before and after."""

    after: GapReport
    """With the effects; as before where nothing was found."""
    before: GapReport
    """With the model as given."""
    noise: DiagnoseNoiseReport
    """The noise floor."""
    sensors: dict[str, SensorGapReport]
    """The same for each sensor by itself, in its unit."""

    _keys = frozenset(["after", "before", "noise", "sensors"])

Held: TypeAlias = Literal["equality", "at-limit", "inactive", "left-out", "wrong"]
"""What a diagnosis did with a constraint of the campaign."""


class HoldoutReport(Node):
    """Leave-one-position-out prediction."""

    after: float | None
    """The same with the effects, in the same unit."""
    before: float
    """Root mean square prediction error before, in standard uncertainties of prediction and reading together: 1 for a true model."""
    positions: int
    """Positions predicted from the others."""
    skipped: int
    """Positions that cannot be left out, because they alone hold a parameter."""

    _keys = frozenset(["after", "before", "positions", "skipped"])

LevelReport: TypeAlias = "float | str"

NoiseFrom: TypeAlias = Literal["stated", "replicates", "residuals"]
"""Where the noise floor comes from."""


class DiagnoseNoiseReport(Node):
    """The noise floor."""

    from_: NoiseFrom
    """`replicates`, `stated` or `residuals` (of the finished model: then completeness cannot be tested)."""
    sd: float | None
    """Standard deviation of a reading of the first sensor, in its unit; null where it is unknown."""

    _keys = frozenset(["from", "sd"])


class PlaceReport(Node):
    """Mean residual at one level of a factor."""

    factor: str
    """The factor."""
    level: LevelReport
    """The level."""
    mean: float
    """Mean residual before, in the sensor's unit."""
    p: float
    """Probability of a mean as large by chance, this level alone."""
    readings: int
    """Readings there."""
    sensor: str
    """The sensor."""
    significant: bool | None
    """Is that below the significance of the diagnosis?"""
    z: float
    """Its size in standard deviations."""

    _keys = frozenset(["factor", "level", "mean", "p", "readings", "sensor", "significant", "z"])


class ResidualReport(Node):
    """A reading's residual before and after."""

    after: float
    """After, in the sensor's unit."""
    before: float
    """Before, in the sensor's unit."""
    index: int
    """Number of the reading, from 1."""
    position: str
    """Its position."""
    sd: float | None
    """Standard deviation of the reading by the noise floor, in the sensor's unit; null where it is unknown."""
    sensor: str
    """The sensor."""

    _keys = frozenset(["after", "before", "index", "position", "sd", "sensor"])


class ScatterReport(Node):
    """A source of scatter."""

    at_zero: bool
    """Did its estimate come out at zero?"""
    dof: float | None
    """Degrees of freedom of the standard deviation; null for infinite."""
    estimated: bool
    """Was it estimated from these readings?"""
    from_: VarianceFrom
    """`stated` or `estimated`."""
    levels: int
    """How many values it took; readings for a sensor's own noise."""
    note: str | None
    """What a person must know of it, in a sentence."""
    of: str
    """What deviates: a sensor, joint, tilt or coefficient."""
    per: str
    """How often it takes a new value: `reading`, `position`, `campaign` or a column."""
    sd: float | None
    """Its standard deviation in `unit`; a factor where uncertainties are stated with each reading; null where it cannot be determined."""
    share: dict[str, float]
    """Share of each parameter's variance."""
    source: str
    """As budgets name it: `readings of V`, `beta per position`, `priors`."""
    tau: float | None
    """Correlation time, where deviations are correlated in time, in the unit of the column that it is correlated over."""
    u_sd: float | None
    """Standard uncertainty of an estimated standard deviation, in `unit`; at zero, what it could be."""
    u_tau: float | None
    """Standard uncertainty of an estimated correlation time, in the same unit."""
    unit: str
    """Unit of the standard deviation."""
    without_u: list[str] | None
    """Estimated parameters without u, since they follow its deviations, and no residual shows how large these are."""

    _keys = frozenset(["at_zero", "dof", "estimated", "from", "levels", "note", "of", "per", "sd", "share", "source", "tau", "u_sd", "u_tau", "unit", "without_u"])


class SensorGapReport(Node):
    """The gap of one sensor."""

    max_after: float
    """Largest residual after, in `unit`."""
    max_before: float
    """Largest residual before, in `unit`."""
    readings: int
    """How many values it gave."""
    rms_after: float | None
    """The same with the effects, in `unit`."""
    rms_before: float | None
    """`sqrt(sum v^2 / r)` before, `r` the sum of its redundancy numbers, in `unit`; null where that is zero."""
    sd: float | None
    """Standard deviation of a reading by the noise floor (root mean square where readings differ), in `unit`."""
    unit: str
    """Its unit."""

    _keys = frozenset(["max_after", "max_before", "readings", "rms_after", "rms_before", "sd", "unit"])


class SensorSizeReport(Node):
    """The size of an effect in one sensor."""

    coefficient: str
    """Name of its coefficient in the repaired model line."""
    p: float
    """Probability of evidence as strong by chance, among all that was tried."""
    probability: float
    """Posterior probability that it or one of its aliases is present there."""
    sensor: str
    """The sensor."""
    t: float
    """Student's t (z where the noise is stated), the other effects given."""
    u: float | None
    """Its standard uncertainty, in `unit`."""
    unit: str
    """Unit."""
    value: float | None
    """The coefficient, in `unit`."""

    _keys = frozenset(["coefficient", "p", "probability", "sensor", "t", "u", "unit", "value"])

State: TypeAlias = Literal["nothing", "named", "suspected", "outside"]
"""What the posterior says of a campaign."""


class SuspectReport(Node):
    """An effect that is suspected."""

    name: str
    """Name in the field's words."""
    probability: float
    """Posterior probability that it or one of its aliases is present, 0.5 to 0.95."""
    regressor: str
    """The appended term without its coefficient."""
    sensor: str | None
    """The sensor; null for what is common to all."""

    _keys = frozenset(["name", "probability", "regressor", "sensor"])


class UnexplainedReport(Node):
    """What is unexplained."""

    cells: list[CellReport]
    """Mean residual at each state of the joints."""
    follows: str | None
    """What readings share that share their deviation (the setting, a joint, a stretch of time); null where each has its own."""
    nearest: list[str]
    """The candidates that come nearest together; they are not accepted."""
    nearest_explains: float
    """Share of the residual sum of squares that those would remove."""
    pattern: str
    """In one sentence."""
    sd: float | None
    """Standard deviation of what is unexplained, in the unit of the first sensor; null where the noise is unknown."""

    _keys = frozenset(["cells", "follows", "nearest", "nearest_explains", "pattern", "sd"])

VarianceFrom: TypeAlias = Literal["stated", "estimated"]
"""Where a standard deviation comes from."""

DiagnoseVerdict: TypeAlias = Literal["effects-found", "partly-explained", "nothing-missing", "unexplained", "not-diagnosable"]
"""The verdict."""


class DiagnoseReport(Report):
    """What `tumble diagnose --json` writes."""

    assumed_zero: list[str]
    """Parameters of the bench that are taken as zero."""
    averaged_from: int | None
    """Readings of a long record, which were averaged; null where each was compared by itself."""
    bench: str
    """Id of the bench."""
    candidates: int
    """How many candidates were tried."""
    constraints: list[AssertedReport]
    """What was done with each constraint of the campaign."""
    distinct_candidates: int
    """How many of them are distinct on this schedule: the number of tests that every p accounts for."""
    effects: list[EffectReport]
    """What is missing, in the order in which it reduces the residuals."""
    gap: GapsReport
    """The gap before and after, and the noise floor."""
    holdout: HoldoutReport | None
    """Leave-one-position-out prediction; null where no position can be predicted from the others."""
    identity: Identity | None
    """The unit under test, when, where, by whom, with what."""
    inputs: list[Input] | None
    """The files that the report was made from, with the SHA-256 of their bytes."""
    model_after: dict[str, str]
    """Model line of each sensor with the effects."""
    model_before: dict[str, str]
    """Model line of each sensor as given."""
    parameters: list[ChangeReport]
    """Each estimated parameter before and after, its uncertainty including possible aliases and unexplained residuals."""
    report: ReportKind
    """Always `diagnose`."""
    residuals: list[ResidualReport]
    """Residual of each reading (of each average in a long record) before and after, for a picture."""
    scatter: list[ScatterReport] | None
    """What scatters, the effects being in the model; empty where only the readings' own noise does."""
    significance: float
    """Probability of reporting anything when nothing is missing."""
    state: State | None
    """What the posterior says: `nothing` is missing, an effect at least is `named`, none is and one at least is `suspected`, or what is
    missing is `outside` the catalogue; absent where nothing can be diagnosed."""
    steps: list[GapStepReport]
    """The gap as given, after the first effect, after the second, and so on."""
    suspected: list[SuspectReport] | None
    """Effects that are probable, but not enough for a name: they are no part of the repaired model."""
    tumble: str
    """Version of the program that wrote it."""
    unexplained: UnexplainedReport | None
    """What is unexplained; null unless the verdict says so."""
    untried_columns: list[str] | None
    """Columns of the readings that were not tried, because their titles are no names of the algebra; `columns` can give them one."""
    verdict: DiagnoseVerdict
    """`effects-found`, `partly-explained`, `nothing-missing`, `unexplained`, or `not-diagnosable` (no redundancy)."""
    where: list[PlaceReport]
    """Where the gap is, the most significant first."""
    would_help: list[dict[str, float]]
    """Positions that would make a diagnosis possible; empty where it is."""

    _keys = frozenset(["assumed_zero", "averaged_from", "bench", "candidates", "constraints", "distinct_candidates", "effects", "gap", "holdout", "identity", "inputs", "model_after", "model_before", "parameters", "report", "residuals", "scatter", "significance", "state", "steps", "suspected", "tumble", "unexplained", "untried_columns", "verdict", "where", "would_help"])


class ArcsecReport(Node):
    """An angle in arcseconds."""

    U: float | None
    """Expanded uncertainty, arcsec."""
    u: float | None
    """Standard uncertainty, arcsec."""
    value: float | None
    """Estimate, arcsec."""

    _keys = frozenset(["U", "u", "value"])


class BinReport(Node):
    """A part of the range of an input."""

    high: float
    """Its upper end, in the input's unit."""
    low: float
    """Its lower end, in the input's unit."""
    mean: float | None
    """Mean residual, in the sensor's unit; null without rows."""
    rows: int
    """Rows in it."""

    _keys = frozenset(["high", "low", "mean", "rows"])


class BinsReport(Node):
    """Residuals over the range of an input."""

    bins: list[BinReport]
    """Mean residual in each eighth of the range."""
    chi_square: float
    """What a step in each eighth of the input's range would explain, over the variance of the noise."""
    dof: int
    """Its degrees of freedom: steps that the model does not have itself."""
    input: str
    """The input: a column of the record."""
    p: float
    """Probability of a larger one if the model is right."""
    rejected: bool
    """Is the model rejected at the level, all inputs and sensors together?"""
    sensor: str
    """The sensor."""

    _keys = frozenset(["bins", "chi_square", "dof", "input", "p", "rejected", "sensor"])


class BudgetReport(Node):
    """A line of a budget."""

    c: float | None
    """Sensitivity coefficient, where the source is one quantity, in the quantity's unit over the source's."""
    distribution: Shape
    """Shape of the distribution."""
    dof: float | None
    """Degrees of freedom; null for infinite."""
    estimate: float | None
    """Estimate of the source, where it is one quantity, in the source's unit."""
    share: float
    """Share of the variance, 0 to 1; of correlated inputs also beyond, and negative."""
    source: str
    """Where it comes from."""
    source_u: float | None
    """Standard uncertainty of the source itself, where it is one quantity, in the source's unit."""
    type: Evaluation
    """`A` or `B`."""
    u: float
    """Contribution to the standard uncertainty, in the quantity's unit; negative for a correlated pair that takes from the variance (its
    square)."""

    _keys = frozenset(["c", "distribution", "dof", "estimate", "share", "source", "source_u", "type", "u"])


class ChecksReport(Node):
    """Do the readings agree with the model?"""

    external: dict[str, ExternalReport]
    """For each parameter, the reading whose undetected fault would do most to it."""
    follows: list[FollowsReport] | None
    """The column that the residuals of a sensor follow, where they have too few runs of one sign in its order."""
    lack_of_fit: LackOfFitReport | None
    """Replicates against what the model leaves; null where nothing is replicated."""
    lack_of_fit_by_position: LackOfFitReport | None
    """What the model leaves between positions against the scatter of the readings of each, where nothing is replicated."""
    normality: NormalityReport | None
    """Shapiro-Francia test of normality; null with fewer than eight residuals."""
    runs: dict[str, RunsReport]
    """Order of the residuals' signs, for each sensor."""
    snooping: SnoopingReport | None
    """Suspicious readings; null in a robust fit, and without redundancy."""
    verdict: list[str]
    """In words, one sentence for each thing found."""

    _keys = frozenset(["external", "follows", "lack_of_fit", "lack_of_fit_by_position", "normality", "runs", "snooping", "verdict"])


class CircleReport(Node):
    """A closed circle that disagrees with the others."""

    mean_residual: float
    """Mean residual of its readings, in its unit."""
    mean_residual_deg: float
    """The same in degrees."""
    sensor: str
    """The sensor."""

    _keys = frozenset(["mean_residual", "mean_residual_deg", "sensor"])


class CombinationReport(Node):
    """A combination of parameters."""

    combination: dict[str, float]
    """Coefficient of each parameter."""
    text: str
    """The same as a line of text."""

    _keys = frozenset(["combination", "text"])


class CombinationValueReport(Node):
    """A combination of parameters that is determined where they alone are not."""

    U: float | None
    """Expanded uncertainty, in `unit`."""
    arcsec: ArcsecReport | None
    """The same in arcseconds, where all its parameters are tilts."""
    budget: list[BudgetReport]
    """Where the uncertainty comes from."""
    combination: dict[str, float]
    """Coefficient of each parameter."""
    dof: float | None
    """Effective degrees of freedom; null for infinite."""
    k: float | None
    """Coverage factor."""
    text: str
    """The same as a line of text."""
    u: float | None
    """Combined standard uncertainty, in `unit`."""
    unit: str
    """Unit: that of the first parameter, whose coefficient is 1."""
    value: float
    """Value, in `unit`."""

    _keys = frozenset(["U", "arcsec", "budget", "combination", "dof", "k", "text", "u", "unit", "value"])


class ConditionalReport(Node):
    """What depends on the value at which a parameter is held that is not estimable."""

    by: float
    """Another value of it was tried: so far away, in `unit`, what it hides in following."""
    held: str
    """The parameter that is held."""
    shifts: dict[str, float]
    """Which estimates change by more than a tenth of their standard uncertainty, and by how many of it."""
    unit: str
    """Unit of `by`."""

    _keys = frozenset(["by", "held", "shifts", "unit"])


class ConformityReport(Node):
    """What the limits of a campaign say about its results."""

    decision: Decision
    """`simple`, `guard-u` or `risk`."""
    outcome: Conformity
    """The worst outcome: `fail` before `undecided` before `pass`."""
    quantities: list[LimitedReport]
    """Each quantity."""
    rule: str
    """The rule in words."""

    _keys = frozenset(["decision", "outcome", "quantities", "rule"])


class ConstraintReport(Node):
    """One constraint."""

    cost: float | None
    """By how much chi-square, a pure number, would be smaller without an active bound."""
    index: int
    """Number in the file, from 1."""
    multiplier: float | None
    """Decrease of chi-square for each unit (radian for tilts) by which an active bound gives way."""
    side: Side | None
    """`lower`, `upper` or `norm` where it is active."""
    state: ConstraintState
    """`equality`, `inactive`, `active` or `contradictory`."""
    text: str
    """The constraint as a line of text."""

    _keys = frozenset(["cost", "index", "multiplier", "side", "state", "text"])

ConstraintState: TypeAlias = Literal["equality", "inactive", "active", "contradictory", "not-applied"]
"""What became of one constraint."""


class ConstraintsReport(Node):
    """The constraints of a campaign and what became of them."""

    cost: float | None
    """By how much the inequalities raise chi-square (the sum of squares over the estimated variance), a pure number."""
    equations: EquationsReport | None
    """What the equations cost; absent where there are none."""
    list_: list[ConstraintReport]
    """Each of them."""
    on_face: list[list[float]] | None
    """Covariance of the constrained estimate on the active face (from the readings), in the order of `covariance`; null where no inequality is
    active. The parameters' own `u` and `interval` do not rely on it."""
    p: float | None
    """Probability of a larger cost if the bounds that are active were true: chi-square, or F where the variance is estimated."""
    rejected: bool | None
    """Is it below one minus the level?"""
    status: ConstraintsStatus
    """`met`, `contradictory` (none was applied) or `not-applied` (a rank defect is left, or the solver gave up)."""
    verdict: str
    """In words."""

    _keys = frozenset(["cost", "equations", "list", "on_face", "p", "rejected", "status", "verdict"])

ConstraintsStatus: TypeAlias = Literal["met", "contradictory", "not-applied"]
"""What became of a campaign's constraints."""


class ConvergenceReport(Node):
    """The record of Gauss-Newton."""

    change: dict[str, float]
    """Exact minus linear estimate of each parameter."""
    converged: bool
    """Did it converge?"""
    held: list[str]
    """Parameters that the reference point does not determine and that kept their reference values."""
    iterations: list[IterationReport]
    """Each iteration."""
    moved: list[str] | None
    """Parameters that no reading responds to at the reference point, where their factor is zero: the iteration started from a point nearby."""
    stop: Stop
    """Why it ended."""

    _keys = frozenset(["change", "converged", "held", "iterations", "moved", "stop"])


class CorrectedSensorFile(Node):
    """A sensor of a correction."""

    axes: dict[str, list[float]]
    """Its named axes, as direction cosines in the frame of the inputs."""
    id: str
    """Its name."""
    model: str
    """Its model line."""
    unit: str
    """Unit of its readings."""

    _keys = frozenset(["axes", "id", "model", "unit"])


class CorrectionFile(Node):
    """How readings of the unit are corrected: to first order `inputs = matrix (readings - bias)`, exactly by the lines in `sensors`."""

    bias: list[float]
    """Readings at zero input, one for each sensor, in the sensor's unit."""
    columns: dict[str, str] | None
    """Titles that sensors and inputs had in the table of the calibration, where they are not their names."""
    force_unit: str
    """Unit of specific forces: `g` or `m/s^2`."""
    frame: str
    """Frame of the inputs: the last frame of the bench's chain."""
    inputs: list[InputFile]
    """What the sensors determine, in the order of the rows of `matrix`; then what must be given with the readings."""
    left_out: dict[str, str] | None
    """Sensors that cannot be corrected, each with the reason."""
    matrix: list[list[float]]
    """Inputs by sensors, at zero input: the inverse of `sensitivity` (least squares where there are more sensors)."""
    mounting: MountingFile | None
    """The rotation from the sensors' frame to the mounting face, where tilts after the last joint are known or estimated."""
    parameters: CorrectionParametersFile
    """Values of the parameters that the lines use, and their covariance."""
    rate_unit: str
    """Unit of rates: `deg/s`, `deg/h`, `rad/s` or `arcsec/s`."""
    sensitivity: list[list[float]]
    """Derivative of each reading (row) by each input (column), at zero input, in the sensor's unit over the input's."""
    sensors: list[CorrectedSensorFile]
    """The sensors that take part, in the order of `bias` and of the columns of `matrix`."""
    validity: ValidityFile
    """Where the first order holds."""

    _keys = frozenset(["bias", "columns", "force_unit", "frame", "inputs", "left_out", "matrix", "mounting", "parameters", "rate_unit", "sensitivity", "sensors", "validity"])


class CorrectionParametersFile(Node):
    """Parameters of a correction."""

    covariance: list[list[float]]
    """Their covariance, estimated and known inputs together, in products of their units; empty where no uncertainty is known."""
    order: list[str]
    """Their names, also of the rows and columns of `covariance`."""
    values_: list[float]
    """Their values (tilts in rad)."""

    _keys = frozenset(["covariance", "order", "values"])


class CovarianceReport(Node):
    """A covariance matrix."""

    matrix: list[list[float | None]]
    """The matrix, row by row, in products of the parameters' units (tilts in rad; correlations are pure numbers); null for what is not
    estimable."""
    order: list[str]
    """Names of the rows and columns."""

    _keys = frozenset(["matrix", "order"])


class DerivedReport(Node):
    """A derived quantity."""

    U: float | None
    """Expanded uncertainty, in `unit`."""
    arcsec: ArcsecReport | None
    """The same in arcseconds, for angles."""
    budget: list[BudgetReport]
    """Where `u` comes from."""
    dof: float | None
    """Effective degrees of freedom; null for infinite."""
    id: str
    """Name."""
    interval: list[float] | None
    """Coverage interval of an azimuth `atan2(y, x)`, in `unit`: the directions that y and x together allow; the whole circle where they may
    both be zero. Of other lines, with inequality constraints, that about the estimate without them, cut to what they allow. Absent where it
    is `value - U` to `value + U`."""
    k: float | None
    """Coverage factor."""
    line: str
    """The line of algebra, as it was written (before it is brought to `unit`); for an error of a scale factor what it is: Y mean readings (`↑`
    from below, `↓` from above) at the rates x, a + b x their straight line (`₊`, `₋` of either sense), `‖ ‖∞` the largest size, s the
    standard deviation over runs."""
    note: str | None
    """What a person must know of it, in a sentence."""
    u: float | None
    """Combined standard uncertainty, in `unit`."""
    unit: str
    """Its unit, as asked for or as the line has it; empty where a parameter in it has none."""
    value: float | None
    """Value, in `unit`; null where it needs what is not estimable."""

    _keys = frozenset(["U", "arcsec", "budget", "dof", "id", "interval", "k", "line", "note", "u", "unit", "value"])

Distribution: TypeAlias = Literal["normal", "rectangular", "triangular", "arcsine"]
"""Shape of the distribution of a known value. `u` is its standard deviation whatever the shape."""


class DrawnReport(Node):
    """One output of the Monte Carlo."""

    first_order: list[float] | None
    """First-order interval, in the quantity's unit; with bounds that of the estimate without them, cut to what they allow."""
    first_order_agrees: bool | None
    """Is the first order as good as two digits of the uncertainty (JCGM 101, clause 8): do both ends of the symmetric interval agree within
    half a unit of the second digit of `u` and the sampling error of the trials? Null where bounds held trials back: the first order is not
    about the constrained estimate."""
    id: str
    """Name of the parameter or derived quantity."""
    interval: list[float]
    """Probabilistically symmetric coverage interval, in the quantity's unit."""
    mean: float
    """Mean of the trials, in the quantity's unit."""
    shortest: list[float]
    """Shortest coverage interval, in the quantity's unit."""
    u: float
    """Standard deviation of the trials, in the quantity's unit."""

    _keys = frozenset(["first_order", "first_order_agrees", "id", "interval", "mean", "shortest", "u"])


class EquationsReport(Node):
    """What the equations among the constraints cost together."""

    cost: float
    """By how much they raise chi-square (the sum of squares over the estimated variance), a pure number."""
    count: int
    """Degrees of freedom of the cost: unknowns that they give and the readings would determine."""
    p: float | None
    """Probability of a larger cost if they were true: chi-square, or F where the variance is estimated; null where nothing is to be tested."""
    rejected: bool | None
    """Is it below one minus the level?"""

    _keys = frozenset(["cost", "count", "p", "rejected"])

Evaluation: TypeAlias = Literal["A", "B"]
"""How a contribution was evaluated (GUM 2.3.2, 2.3.3)."""


class ExternalReport(Node):
    """External reliability of a parameter."""

    effect: float
    """What its smallest detectable fault would do to the parameter, undetected (tilts in arcseconds)."""
    index: int
    """Number of the reading, from 1."""

    _keys = frozenset(["effect", "index"])


class FarReport(Node):
    """A residual that is far from zero."""

    p: float
    """Probability of so large a one among all rows if none is bad."""
    residual: float
    """Value minus fitted, in the sensor's unit."""
    row: int
    """Number of the row, from 1."""
    value: float
    """Value read, in the sensor's unit."""
    w: float
    """Residual of the independent row, in its standard deviations."""

    _keys = frozenset(["p", "residual", "row", "value", "w"])


class FitSummary(Node):
    """Sums over the whole fit."""

    at_rounding: list[str] | None
    """Sensors whose readings scatter by no more than the rounding of their numbers; their standard deviation is that rounding."""
    chi_square: float | None
    """The same where all uncertainties are stated: chi-square."""
    condition: float | None
    """Condition number of the scaled design matrix."""
    dof: int
    """Degrees of freedom."""
    global_test_rejected: bool | None
    """Is `p` below one minus the level, so that the model or the uncertainties are rejected? Absent where there is no such test."""
    inconsistent_circles: list[CircleReport] | None
    """Closed circles whose readings disagree with all others by degrees: mean of what is left, in the sensor's unit; the worst first."""
    linearisation_error: float | None
    """Largest difference between exact and linear model at the solution, in units of the readings' standard uncertainty."""
    p: float | None
    """Probability of a larger chi-square if the model is right."""
    priors: int
    """Prior rows."""
    rank: int
    """Rank of the design matrix."""
    rank_tolerance: float
    """Rank tolerance, relative to the largest diagonal element of R."""
    readings: int
    """Values read (rows), without priors."""
    rejected: bool
    """Is the answer "rejected" (rank defect, uncertainties that cannot be known, failed global test, no convergence)?"""
    remarks: list[str] | None
    """What a person should look at: angles that may be radians, an absurd condition number."""
    residual_sd: float | None
    """`sqrt(sum_of_squares / dof)`: in the sensor's unit where no uncertainty is stated, else a pure number that should be near 1."""
    resolution: dict[str, float] | None
    """The last decimal place of their readings, for those whose standard deviation is that of rounding to it, `step/sqrt 12`."""
    sensor_sd: dict[str, float | None]
    """Estimated standard deviation of each sensor whose scatter was estimated."""
    sum_of_squares: float
    """Weighted sum of squared residuals, in the square of the unit of `residual_sd`."""
    variance: VarianceFrom
    """`stated` (uncertainties as given) or `estimated` (from the residuals)."""

    _keys = frozenset(["at_rounding", "chi_square", "condition", "dof", "global_test_rejected", "inconsistent_circles", "linearisation_error", "p", "priors", "rank", "rank_tolerance", "readings", "rejected", "remarks", "residual_sd", "resolution", "sensor_sd", "sum_of_squares", "variance"])


class FollowsReport(Node):
    """Residuals that follow a column."""

    column: str
    """The column of the readings."""
    expected: float
    """Mean number of runs to be expected."""
    p: float
    """Probability of so few in any of the orders that were tried."""
    runs: int
    """Runs of equal sign in its order; readings of one value are in the order of the other columns."""
    sensor: str
    """The sensor."""

    _keys = frozenset(["column", "expected", "p", "runs", "sensor"])

GravityBasis: TypeAlias = Literal["stated", "normal", "assumed"]
"""Where the value of gravity comes from."""


class GravityReport(Node):
    """Local gravity."""

    altitude_m: float | None
    """Altitude above the ellipsoid in metres, for normal gravity."""
    formula: str | None
    """The formula, for normal gravity."""
    from_: GravityBasis
    """`stated`, `normal` (from latitude and altitude) or `assumed` (standard gravity)."""
    u: float
    """Standard uncertainty, in `unit`; 0 where none was given."""
    unit: str
    """`m/s^2`."""
    value: float
    """Value, in `unit`."""

    _keys = frozenset(["altitude_m", "formula", "from", "u", "unit", "value"])


class InputFile(Node):
    """An input of a correction."""

    direction: list[float] | None
    """Direction of a rate or force in the frame of the inputs, pure numbers whose squares sum to 1."""
    id: str
    """Its name, for example `w_x`."""
    otherwise: float | None
    """Value of a given input where the readings do not give it, in the input's unit."""
    quantity: QuantityFile
    """`rate`, `force`, `column` or `angle`."""
    solved: bool
    """Is it solved for? Otherwise it is given with the readings."""
    unit: str
    """Unit."""

    _keys = frozenset(["direction", "id", "otherwise", "quantity", "solved", "unit"])


class IterationReport(Node):
    """One iteration."""

    share: float
    """Share of the step taken, 0 to 1."""
    step: float
    """Norm of the weighted change of the predictions."""
    sum_of_squares: float
    """Weighted sum of squares before the step, in the square of the unit of `residual_sd`."""

    _keys = frozenset(["share", "step", "sum_of_squares"])


class JointReport(Node):
    """Several outputs together."""

    covariance: list[list[float]]
    """Covariance, in products of the quantities' units."""
    k_p: float | None
    """Factor of the coverage ellipsoid, a pure number; null where they depend on each other."""
    order: list[str]
    """Their order."""

    _keys = frozenset(["covariance", "k_p", "order"])

Kind: TypeAlias = Literal["tilt", "coefficient"]
"""Coefficient of a model line or tilt of the chain."""


class KnownReport(Node):
    """A known parameter as the campaign gives it (tilts in radians)."""

    distribution: Distribution
    """Shape of the distribution."""
    dof: float | None
    """Degrees of freedom; null for infinite."""
    id: str
    """Name."""
    u: float
    """Standard uncertainty, in `unit`."""
    unit: str
    """Unit."""
    value: float
    """Value, in `unit`."""

    _keys = frozenset(["distribution", "dof", "id", "u", "unit", "value"])


class LackOfFitReport(Node):
    """The test for lack of fit."""

    between_dof: int
    """Degrees of freedom of what the model leaves between the means."""
    f: float | None
    """F, a pure number: `(between / between_dof) / pure_error_sd^2`."""
    p: float
    """Probability of a larger F if the model is right."""
    pure_error_dof: int
    """Degrees of freedom of the replicates' scatter, or of that within positions."""
    pure_error_sd: float
    """Factor by which its standard deviation differs from the weights' (1 where uncertainties are right)."""
    rejected: bool
    """Is the model rejected: is `p` below one minus the level, which all tests of the pattern of the residuals share?"""
    sensor: str | None
    """The sensor whose readings are tested, where the scales of several are estimated: the one with the smallest p; absent where all are
    tested together."""

    _keys = frozenset(["between_dof", "f", "p", "pure_error_dof", "pure_error_sd", "rejected", "sensor"])


class LagReport(Node):
    """Correlation of residuals."""

    correlation: float
    """Correlation, a pure number."""
    rows: int
    """Rows apart."""

    _keys = frozenset(["correlation", "rows"])


class LimitedReport(Node):
    """A quantity and its limits, in `unit`."""

    U: float | None
    """Expanded uncertainty, in `unit`."""
    id: str
    """Name."""
    lower: float | None
    """Lower limit, in `unit`; null for none."""
    outcome: Conformity
    """`pass`, `fail` or `undecided`."""
    probability: float | None
    """Probability that the quantity is inside the limits, by Student's t about the estimate; null where no uncertainty is known."""
    unit: str
    """Unit of all its numbers: arcsec for angles."""
    upper: float | None
    """Upper limit, in `unit`; null for none."""
    value: float | None
    """Estimate, in `unit`; null where it is not estimable."""

    _keys = frozenset(["U", "id", "lower", "outcome", "probability", "unit", "upper", "value"])


class MeansReport(Node):
    """Means of so many rows."""

    p: float
    """Probability of a ratio so far from 1, on either side."""
    pairs: int
    """Pairs of neighbouring means that were compared."""
    ratio: float
    """Variance of these means over that of means of independent rows, a pure number; 1 is expected."""
    rows: int
    """Rows in a mean."""

    _keys = frozenset(["p", "pairs", "ratio", "rows"])


class MonteCarloReport(Node):
    """Monte Carlo compared with the first order."""

    asked: int
    """Trials asked for."""
    held: bool | None
    """Did bounds hold any trial back? What was drawn is the constrained estimate."""
    joint: JointReport | None
    """Several outputs together (GUM Supplement 2): the derived quantities, or the parameters where fewer than two are derived."""
    outputs: list[DrawnReport]
    """Each output."""
    seed: int
    """Seed."""
    trials: int
    """Trials that gave finite values."""
    verdict: list[str]
    """In words."""

    _keys = frozenset(["asked", "held", "joint", "outputs", "seed", "trials", "verdict"])


class MountingFile(Node):
    """How the sensors' frame is turned against the mounting face."""

    by_tilt: list[list[list[float]]] | None
    """Derivative of `rotation` by each tilt, per rad. Files of earlier versions have none: the rotation then counts as exact."""
    covariance: list[list[float]] | None
    """Covariance of the tilts (rows) with the parameters of `parameters.order` and then with the tilts themselves, in products of their units;
    empty where it is not known."""
    missing: list[str] | None
    """Those of them that are not estimable; the rotation holds them at their reference."""
    rotation: list[list[float]]
    """`v_mount = rotation v_sensor`, row by row, a pure number."""
    tilts: list[str]
    """The tilts, in chain order."""

    _keys = frozenset(["by_tilt", "covariance", "missing", "rotation", "tilts"])


class NormalityReport(Node):
    """The test of normality."""

    p: float
    """Probability of a smaller one for normal errors."""
    rejected: bool | None
    """Is it below one minus the level, which all tests of the pattern of the residuals share?"""
    w: float
    """Shapiro-Francia W'."""

    _keys = frozenset(["p", "rejected", "w"])


class NotEstimableReport(Node):
    """A rank defect."""

    combination: dict[str, float]
    """The combination that the readings leave free."""
    direction: dict[str, float]
    """Along which direction it is free: parameters may move in these proportions and no reading changes."""
    estimable: list[CombinationReport]
    """What is determined instead."""
    hides: str | None
    """Which parameter hides in which others, where they are more than one."""
    separate_by: dict[str, float] | None
    """The further position that would separate it, as reading keys; null if no position of this bench would."""
    separate_sensor: str | None
    """The sensor to be read there, where it is one that no reading has now."""
    text: str
    """The same as a line of text."""
    weak: bool | None
    """Do readings respond to it, but only in the second order, or through a factor that they do not distinguish from zero? Then nothing is
    known of other positions."""

    _keys = frozenset(["combination", "direction", "estimable", "hides", "separate_by", "separate_sensor", "text", "weak"])


class ParameterReport(Node):
    """An estimated parameter."""

    U: float | None
    """Expanded uncertainty, in `unit`."""
    arcsec: ArcsecReport | None
    """The same in arcseconds, for tilts."""
    budget: list[BudgetReport]
    """Where `u` comes from."""
    dof: float | None
    """Effective degrees of freedom; null for infinite."""
    id: str
    """Name."""
    interval: list[float] | None
    """Coverage interval, in `unit`: `value - U` to `value + U`, but with inequality constraints about the estimate without them, cut to what
    they allow; null where no uncertainty is known, or where constraints and readings leave nothing."""
    k: float | None
    """Coverage factor."""
    kind: Kind
    """`tilt` or `coefficient`."""
    level: float
    """Coverage probability of the expanded uncertainty."""
    state: FitState
    """`free`, `at-bound`, `fixed` (equations leave it one value) or `not-estimable`."""
    type_a: float | None
    """Part of `u` evaluated from the scatter of the readings (or their stated uncertainties), in `unit`."""
    type_b: float | None
    """Part of `u` from known inputs and priors, in `unit`."""
    u: float | None
    """Combined standard uncertainty, in `unit`."""
    unit: str
    """Unit of value and uncertainties."""
    value: float | None
    """Estimate, in `unit`; null where it is not estimable."""

    _keys = frozenset(["U", "arcsec", "budget", "dof", "id", "interval", "k", "kind", "level", "state", "type_a", "type_b", "u", "unit", "value"])

QuantityFile: TypeAlias = Literal["rate", "force", "column", "angle"]
"""What an input is."""


class ReadingReport(Node):
    """One value that was read."""

    external: dict[str, float] | None
    """What a fault of that size would do to each parameter, undetected (external reliability); tilts in arcseconds."""
    fitted: float
    """Value of the fitted model, in the sensor's unit."""
    index: int
    """Number of the reading in the file, from 1."""
    leverage: float
    """Diagonal of the hat matrix, 0 to 1."""
    mdb: float | None
    """Minimal detectable bias, in the sensor's unit."""
    position: str
    """Its position label."""
    redundancy: float
    """Redundancy number, 0 to 1."""
    residual: float
    """Value minus fitted, in the sensor's unit."""
    robust_weight: float | None
    """Weight of the robust estimator, 0 to 1."""
    sensor: str
    """The sensor."""
    studentized: float | None
    """Internally studentized residual, a pure number."""
    u: float | None
    """Standard uncertainty that the adjustment used, in the sensor's unit."""
    value: float
    """Value read, in the sensor's unit."""

    _keys = frozenset(["external", "fitted", "index", "leverage", "mdb", "position", "redundancy", "residual", "robust_weight", "sensor", "studentized", "u", "value"])


class RecordReport(Node):
    """A record whose rows are the readings."""

    inputs: list[BinsReport]
    """Lack of fit over the ranges of the inputs."""
    passes: int
    """Passes over the record."""
    rows: int
    """Rows of the record."""
    sensors: list[RecordSensorReport]
    """The residuals of each sensor."""
    shown: int
    """Rows that the list of readings and the pictures show."""
    values_: int
    """Values that were read."""

    _keys = frozenset(["inputs", "passes", "rows", "sensors", "shown", "values"])


class RecordSensorReport(Node):
    """Residuals of independent rows (the noise that is correlated in time taken out), over their standard deviations."""

    excess_kurtosis: float
    """Kurtosis less 3, a pure number; 0 for normal residuals."""
    lags: list[LagReport]
    """Correlation of residuals that are so many rows apart."""
    lags_p: float | None
    """Probability of so large correlations of independent residuals; null for few rows."""
    largest: list[FarReport]
    """The largest, first."""
    mean_square: float
    """Mean square, a pure number; 1 is expected."""
    means: list[MeansReport]
    """Do means of many rows scatter as those of independent ones?"""
    sensor: str
    """The sensor."""
    skewness: float
    """Skewness, a pure number; 0 for normal residuals."""
    values_: int
    """Values read."""

    _keys = frozenset(["excess_kurtosis", "lags", "lags_p", "largest", "mean_square", "means", "sensor", "skewness", "values"])

RobustMethod: TypeAlias = Literal["huber", "tukey", "l1"]
"""Which estimator."""


class RobustReport(Node):
    """The robust estimator."""

    converged: bool
    """Did it settle?"""
    downweighted: list[int]
    """Readings with less than half of their weight, by number."""
    iterations: int
    """Steps of reweighting."""
    method: RobustMethod
    """`huber`, `tukey` or `l1`."""

    _keys = frozenset(["converged", "downweighted", "iterations", "method"])


class RunsReport(Node):
    """The runs test."""

    expected: float
    """Mean number of runs to be expected."""
    p: float
    """Two-sided probability."""
    rejected: bool | None
    """Is it below one minus the level, which all tests of the pattern of the residuals share?"""
    runs: int
    """Runs of equal sign."""

    _keys = frozenset(["expected", "p", "rejected", "runs"])

Shape: TypeAlias = Literal["normal", "t", "rectangular", "triangular", "arcsine"]
"""Shape of the distribution of a contribution."""

Side: TypeAlias = Literal["lower", "upper", "norm"]
"""Which side of a constraint is active."""


class SiteReport(Node):
    """What the inputs of the model lines rest on."""

    earth_rate_deg_h: float
    """Earth rate, deg/h."""
    gravity: GravityReport
    """Local gravity."""
    latitude_deg: float | None
    """Geodetic latitude, degrees; null where the bench has no site."""
    latitude_u_deg: float
    """Its standard uncertainty, degrees."""
    rate_u_ppm: dict[str, float] | None
    """Relative standard uncertainties of the rates of turning joints, ppm."""
    warnings: list[str] | None
    """Warnings, as sentences."""

    _keys = frozenset(["earth_rate_deg_h", "gravity", "latitude_deg", "latitude_u_deg", "rate_u_ppm", "warnings"])


class SnoopingReport(Node):
    """Data snooping."""

    single_level: float
    """Significance for a single reading (Sidak), a probability."""
    suspects: list[FitSuspectReport]
    """Suspicious readings."""
    tested: int
    """Readings tested."""
    without_suspects: dict[str, float]
    """How each parameter would change without them (tilts in arcseconds)."""

    _keys = frozenset(["single_level", "suspects", "tested", "without_suspects"])

FitState: TypeAlias = Literal["free", "at-bound", "fixed", "not-estimable"]
"""What the fit can say about a parameter."""

Stop: TypeAlias = Literal["the last step no longer matters", "the scales inside the last step did not settle", "the steps did not end", "steps stay long while the fit no longer becomes better: the readings hardly determine some direction", "no part of the last step makes the fit better", "the readings are far less likely at the solution than at the reference point", "numbers leave the range of a double"]
"""Why Gauss-Newton ended."""


class FitSuspectReport(Node):
    """A suspicious reading."""

    index: int
    """Number of the reading, from 1."""
    p: float
    """Probability of so large a shift among all readings if none were bad."""
    position: str
    """Its position label."""
    sensor: str
    """The sensor."""
    shift: float
    """Its shift against the other readings, in the sensor's unit."""
    u: float
    """Standard uncertainty of the shift, in the sensor's unit."""
    w: float
    """`shift / u`."""

    _keys = frozenset(["index", "p", "position", "sensor", "shift", "u", "w"])


class ValidityFile(Node):
    """How far the first-order correction is from the exact one over the range of the calibration."""

    linear_error: list[float]
    """Largest error of `matrix (readings - bias)` within that range, in the input's unit."""
    linear_share: float | None
    """Share of the range within which `linear_error` stays below `u` (1: all of it); null where no uncertainty is known."""
    range: list[float]
    """Half range of each solved input: what the readings of the calibration covered."""
    u: list[float] | None
    """Largest standard uncertainty of each corrected input within that range, from the calibration alone; null where none is known."""

    _keys = frozenset(["linear_error", "linear_share", "range", "u"])


class FitReport(Report):
    """What `tumble fit --json` writes."""

    assumed_zero: list[str]
    """Parameters that the bench has and the campaign neither knows nor estimates."""
    bench: str
    """Id of the bench."""
    checks: ChecksReport
    """Do the readings agree with the model?"""
    conditional: list[ConditionalReport] | None
    """Estimates that depend on the values at which something that is not estimable is held: their `U` holds only given those."""
    conformity: ConformityReport | None
    """Conformity with the limits of the campaign, where it has any."""
    constraints: ConstraintsReport | None
    """What became of the campaign's constraints."""
    convergence: ConvergenceReport | None
    """The record of Gauss-Newton; absent with `--linear`."""
    correction: CorrectionFile | None
    """How readings of this unit are corrected; absent where no sensor follows a rate or specific force that the fit determines."""
    correlation: CovarianceReport
    """Correlations of the estimated parameters."""
    correlations: list[list[str | float]] | None
    """Correlation coefficients of pairs of known parameters, as given; others are independent."""
    covariance: CovarianceReport
    """Covariance of the estimated parameters, readings and known inputs together."""
    derived: list[DerivedReport]
    """Quantities computed from parameters."""
    estimable_combinations: list[CombinationValueReport] | None
    """What is determined of parameters that are not estimable alone, with values."""
    estimator: Estimator
    """`exact`, or `linear` with `--linear`."""
    fit: FitSummary
    """Sums over the whole fit."""
    identity: Identity | None
    """The unit under test, when, where, by whom, with what."""
    inputs: list[Input] | None
    """The files that the report was made from, with the SHA-256 of their bytes."""
    known: list[KnownReport]
    """Known parameters, as given."""
    model: dict[str, str]
    """Model line of each sensor."""
    monte_carlo: MonteCarloReport | None
    """Monte Carlo, with `--monte-carlo`."""
    nonlinear: dict[str, float] | None
    """Parameters whose exact and linear estimates differ by more than a tenth of their standard uncertainty, and by how many of it (exact
    minus linear; with `--linear`, what Gauss-Newton would change next)."""
    not_estimable: list[NotEstimableReport]
    """What the readings leave free."""
    parameters: list[ParameterReport]
    """The estimated parameters."""
    readings: list[ReadingReport]
    """Each value that was read."""
    record: RecordReport | None
    """The record, where its rows are the readings (`"as": "rows"`); `readings` is then a sample of them."""
    report: ReportKind
    """Always `fit`."""
    robust: RobustReport | None
    """The robust estimator, with `--robust`."""
    scatter: list[ScatterReport]
    """What scatters in the readings."""
    site: SiteReport
    """Latitude, Earth rate and gravity."""
    tumble: str
    """Version of the program that wrote it."""

    _keys = frozenset(["assumed_zero", "bench", "checks", "conditional", "conformity", "constraints", "convergence", "correction", "correlation", "correlations", "covariance", "derived", "estimable_combinations", "estimator", "fit", "identity", "inputs", "known", "model", "monte_carlo", "nonlinear", "not_estimable", "parameters", "readings", "record", "report", "robust", "scatter", "site", "tumble"])

Agreement: TypeAlias = Literal["agrees", "disagrees", "not-predicted"]
"""Whether a reading agrees with the others."""

Ending: TypeAlias = Literal["reached", "nothing-to-gain", "most-readings"]
"""Why a guide ended."""


class Estimated(Node):
    """An estimated parameter so far."""

    id: str
    """Its name."""
    u: float | None
    """Its standard uncertainty, in `unit`."""
    unit: str
    """Unit of both."""
    value: float | None
    """Its value, in `unit`; none while it is not estimable."""

    _keys = frozenset(["id", "u", "unit", "value"])


class Explanation(Node):
    """One explanation of a reading that does not agree."""

    kind: MistakeKind
    """The kind of mistake."""
    probability: float
    """Its probability."""
    reading: int
    """Number of the reading at which it was made, from 1."""
    what: str
    """The setting, sensors, tilt or effect."""

    _keys = frozenset(["kind", "probability", "reading", "what"])


class GuideHeld(Node):
    """A position while samples come."""

    candidates: list[str]
    """Settings that agree, where it is asked for which one it is."""
    held_s: float
    """How long it has been held, without guard times, s."""
    means: list[HeldMean]
    """Each sensor's mean so far."""
    position: str
    """Label of the position that it is taken for."""
    setting: str
    """Its setting."""
    state: Holding
    """What the bench does."""
    until_s: float
    """Time of the newest sample that this is of, s since the first row."""
    wait_s: float | None
    """How much longer it is to be held, s; none where that is not known yet, or holding it does not reach what is wanted."""

    _keys = frozenset(["candidates", "held_s", "means", "position", "setting", "state", "until_s", "wait_s"])


class HeldMean(Node):
    """The mean of a sensor so far."""

    mean: float
    """The mean, in `unit`."""
    sensor: str
    """The sensor."""
    u: float
    """Its standard uncertainty, in `unit`."""
    unit: str
    """Unit of these."""
    wanted: float
    """The standard uncertainty that is wanted, in `unit`."""

    _keys = frozenset(["mean", "sensor", "u", "unit", "wanted"])

Holding: TypeAlias = Literal["moving", "held", "read", "which", "left"]
"""What the samples say of the bench."""


class Lacks(Node):
    """What the model lacks."""

    effects: list[Named]
    """Effects that are named."""
    gap_after: float | None
    """The same ratio of variances with the effects that are named."""
    gap_before: float | None
    """Sum of squares of the residuals over its degrees of freedom, the model as given: a ratio of variances, near 1 where nothing is missing."""
    verdict: GuideVerdict
    """The verdict, as `diagnose` says it."""

    _keys = frozenset(["effects", "gap_after", "gap_before", "verdict"])


class Mistake(Node):
    """What may have gone wrong."""

    at: int | None
    """Number of the reading at which it was made, where that has a probability of at least 0.95."""
    chance: float
    """Probability that it is chance."""
    explanations: list[Explanation]
    """Explanations, the most probable first: as many as have a probability of 0.95 together."""
    named: MistakeKind | None
    """The kind of mistake, where it has a probability of at least 0.95."""
    reading: int
    """Number of the reading that does not agree, from 1."""

    _keys = frozenset(["at", "chance", "explanations", "named", "reading"])

MistakeKind: TypeAlias = Literal["turned-180", "another-position", "wrong-sense", "exchanged-axes", "exchanged-sensors", "slipped-mounting", "bad-reading", "missing-effect"]
"""What may have gone wrong at the bench."""


class Named(Node):
    """An effect that is named."""

    aliases: list[str]
    """What else it could be."""
    name: str
    """Its name."""
    probability: float
    """Probability that it, or one of its aliases, is there."""
    regressor: str
    """The term, as `diagnose` writes it."""
    u: float | None
    """Standard uncertainty of the coefficient, in `unit`."""
    unit: str
    """Unit of both."""
    value: float | None
    """Its coefficient, in `unit`."""

    _keys = frozenset(["aliases", "name", "probability", "regressor", "u", "unit", "value"])


class Newest(Node):
    """The newest reading, against what the others predict."""

    agreement: Agreement
    """Does it agree?"""
    deviation: float | None
    """How far it is from what the others predict, all its values together, in standard deviations: the normal deviate that chance exceeds with
    probability `p`, which decides; negative where the value that is furthest off is below."""
    level: float
    """The probability below which it does not agree: their sum over all readings is the family-wise level."""
    p: float | None
    """Probability of a difference as large by chance."""
    position: str
    """Its position's label."""
    reading: int
    """Number of the reading, from 1."""
    remarks: list[str]
    """What is odd about its other columns."""
    setting: str
    """Its setting."""

    _keys = frozenset(["agreement", "deviation", "level", "p", "position", "reading", "remarks", "setting"])


class Next(Node):
    """The position to set next."""

    between: list[str]
    """Explanations that it tells apart."""
    cost: float
    """What setting and reading it costs, from where the bench stands, in the unit of the costs that were given."""
    information: float | None
    """What it is expected to tell, in nats (a pure number)."""
    position: str
    """Label of the position."""
    set: dict[str, float]
    """The setting as keys of a reading, in the units that the keys name."""
    setting: str
    """The setting, for a person."""
    why: Why
    """Why this one."""

    _keys = frozenset(["between", "cost", "information", "position", "set", "setting", "why"])


class Progress(Node):
    """A goal and how far it is."""

    goal: float
    """The standard uncertainty that is wanted, in `unit`."""
    id: str
    """The parameter or derived quantity."""
    met: bool
    """Is it met?"""
    u: float | None
    """Its standard uncertainty, in `unit`."""
    unit: str
    """Unit of these."""
    value: float | None
    """Its value, in `unit`; none while it is not estimable."""

    _keys = frozenset(["goal", "id", "met", "u", "unit", "value"])


class Residual(Node):
    """What the model in use leaves of a value."""

    in_sd: float
    """The residual in standard deviations of the value."""
    reading: int
    """Number of the reading, from 1."""
    residual: float
    """Value less prediction, in `unit`."""
    sensor: str
    """The sensor."""
    unit: str
    """Unit of the sensor."""

    _keys = frozenset(["in_sd", "reading", "residual", "sensor", "unit"])


class Suspected(Node):
    """An effect that the model may lack."""

    name: str
    """Its name."""
    probability: float
    """Its probability."""
    regressor: str
    """The term, as `diagnose` writes it."""

    _keys = frozenset(["name", "probability", "regressor"])

GuideVerdict: TypeAlias = Literal["effects-found", "partly-explained", "nothing-missing", "unexplained", "not-diagnosable"]
"""The verdict."""

Why: TypeAlias = Literal["information", "tells-apart", "again"]
"""Why a position comes next."""


class GuideReport(Report):
    """A line of `tumble guide --json -`: what is said after each reading and each undone one, after a line that was refused, and while a
    position is held."""

    cost: float
    """What their work cost, in the unit of the costs that were given."""
    diagnosis: Lacks | None
    """What the model lacks."""
    ended: Ending | None
    """Why no more is asked for."""
    error: str | None
    """Why the last line was refused: the advice is that of before."""
    goals: list[Progress]
    """Every goal."""
    held: GuideHeld | None
    """The position that is held, where samples come: the advice is that of before."""
    mistake: Mistake | None
    """What could have gone wrong, while a reading does not agree."""
    newest: Newest | None
    """The newest reading, against the others."""
    next: Next | None
    """The position to set next; none at the end."""
    nothing_missing_or_named: float
    """Probability that nothing is missing, or that all of it is named."""
    parameters: list[Estimated]
    """Every estimated parameter."""
    readings: int
    """Readings that stand."""
    report: ReportKind
    """Always `guide`."""
    residuals: list[Residual]
    """What the model in use leaves of every value."""
    suspected: list[Suspected]
    """What else the model may lack, the most probable first."""
    tumble: str
    """Version of the program that wrote it."""
    unreachable: list[str]
    """Goals that no number of readings at these positions reaches."""
    unseen_effects: int
    """Effects of the catalogue that these readings could not have shown."""

    _keys = frozenset(["cost", "diagnosis", "ended", "error", "goals", "held", "mistake", "newest", "next", "nothing_missing_or_named", "parameters", "readings", "report", "residuals", "suspected", "tumble", "unreachable", "unseen_effects"])


class ChannelReport(Node):
    """The gap in one channel of one run."""

    column: str
    """The column; its name has the unit of all numbers here."""
    max_after: float
    """Largest by size after, in the column's unit."""
    max_before: float
    """Largest by size before, in the column's unit."""
    motion: str
    """Name of the motion."""
    rms_after: float
    """Root mean square after, in the column's unit."""
    rms_before: float
    """Root mean square before, in the column's unit."""
    u: float
    """Standard uncertainty of a value, in the column's unit."""
    u_from: NoiseFrom
    """`stated` or `residuals` (then it can only come from what is left)."""
    values_: int
    """Values measured."""

    _keys = frozenset(["column", "max_after", "max_before", "motion", "rms_after", "rms_before", "u", "u_from", "values"])


class LegFile(Node):
    """One leg; the last may have no duration and ends with the mission."""

    acceleration_m_s2: float
    """Acceleration along the heading, m/s^2; 0 cruises (or rests)."""
    duration_h: float | None
    """Duration, h."""
    duration_s: float | None
    """Duration, s, instead."""
    turn_deg_s: float | None
    """Rate of the heading, deg/s clockwise: a flat turn, without bank."""

    _keys = frozenset(["acceleration_m_s2", "duration_h", "duration_s", "turn_deg_s"])


class LegsFile(Node):
    """Legs along a heading, which turns only where a leg says so."""

    heading_deg: float
    """At the start, clockwise from north, degrees."""
    legs: list[LegFile]
    """One leg after another."""
    speed_m_s: float
    """Speed at the start, m/s."""
    swing: SwingFile | None
    """A swing under way, about the course."""

    _keys = frozenset(["heading_deg", "legs", "speed_m_s", "swing"])

MotionFile: TypeAlias = "dict[str, Any]"


class NavigationAliasReport(Node):
    """Another error that explains the same."""

    absurd: bool
    """Would it need a size that no navigator's unit has?"""
    exact: bool
    """The same column exactly (true), or only a fit that is not significantly worse (false)."""
    excess: float
    """How much worse it fits, in variances of the noise."""
    name: str
    """Its name."""
    regressor: str
    """The error source."""
    together_with: str | None
    """A second error that must then replace another one that was found."""
    unit: str
    """Its unit."""
    value: float | None
    """The change of the mission that it would need, in `unit`."""

    _keys = frozenset(["absurd", "exact", "excess", "name", "regressor", "together_with", "unit", "value"])


class NavigationCellReport(Node):
    """Mean gap in a part of a run."""

    column: str
    """The column."""
    from_h: float
    """Start of the part, h."""
    mean: float
    """Mean gap, in the column's unit."""
    motion: str
    """Name of the motion."""
    to_h: float
    """End of the part, h."""
    values_: int
    """Values there."""
    z: float
    """Its size in standard deviations."""

    _keys = frozenset(["column", "from_h", "mean", "motion", "to_h", "values", "z"])


class NavigationEffectReport(Node):
    """An error that the mission misses."""

    after: float | None
    """The mission's value after, in `unit`."""
    aliases: list[NavigationAliasReport]
    """What else it could be."""
    before: float | None
    """The mission's value before, in `unit`; null where no mission holds such a cause."""
    explains: float
    """Share of the residual sum of squares that it removes."""
    name: str
    """Name in the field's words."""
    p: float
    """Probability of evidence as strong by chance, among all that was tried."""
    probability: float | None
    """Probability that it, or an error that cannot be distinguished from it, is present; absent for random walks and single values."""
    regressor: str
    """The cause: an error source as mission files name it, such a bias with its change in time (`gyro_bias_x:ramp`, `gyro_bias_x:wave(3600)`),
    a random walk (`angle_random_walk`, `velocity_random_walk`; of biases `rate_random_walk`, `acceleration_random_walk_x`), a fault of the
    reference (`reference:phi_up_arcsec:step(7200)`), or a single value (`reading:17`, the number of its row)."""
    separate_by: list[SeparationReport]
    """Motions that would discriminate them, best first; as a mission file has them."""
    t: float
    """Student's t (normal where the noise is stated), the other effects given."""
    u: float | None
    """Standard uncertainty, in `unit`."""
    unit: str
    """Unit."""
    value: float
    """What the mission has to be changed by, in `unit`."""

    _keys = frozenset(["after", "aliases", "before", "explains", "name", "p", "probability", "regressor", "separate_by", "t", "u", "unit", "value"])


class NavigationGapStepReport(Node):
    """The gap with some of the causes that were found."""

    gap: GapReport
    """The gap."""
    left_out: int
    """Single values that are left out."""
    with_: list[str]
    """The causes."""

    _keys = frozenset(["gap", "left_out", "with"])


class NavigationSuspectReport(Node):
    """A single value that noise does not explain."""

    column: str
    """The column."""
    motion: str
    """Name of the motion."""
    time_s: float
    """Time, s."""
    z: float
    """What is left of it, in standard uncertainties."""

    _keys = frozenset(["column", "motion", "time_s", "z"])


class NavigateDiagnoseNoiseReport(Node):
    """The noise floor."""

    from_: NoiseFrom
    """`replicates`, `stated` or `residuals` (of the finished model: then completeness cannot be tested)."""
    sd: float | None
    """Standard deviation of a reading of the first sensor, in its unit; null where it is unknown."""

    _keys = frozenset(["from", "sd"])


class OscillationFile(Node):
    """One angle of a swing."""

    amplitude_deg: float
    """Amplitude, degrees."""
    mean_deg: float
    """Mean, degrees."""
    period_s: float | None
    """Period, s; needed where there is an amplitude."""
    phase_deg: float
    """Phase at the start, degrees."""

    _keys = frozenset(["amplitude_deg", "mean_deg", "period_s", "phase_deg"])


class QuantityWithUnit(Node):
    """A value with its unit."""

    unit: str
    """Unit."""
    value: float
    """Value, in `unit`."""

    _keys = frozenset(["unit", "value"])


class RunReport(Node):
    """A run that was measured."""

    motion: str
    """Name of the mission's motion."""
    rows: int
    """Rows."""

    _keys = frozenset(["motion", "rows"])


class SeparationReport(Node):
    """A motion that would discriminate an error from its aliases."""

    by: float
    """By how many standard deviations at least, with as many rows and the same noise as the first run."""
    is_: str
    """In words."""
    motion: MotionFile
    """The motion, as a mission file has it."""
    tells: list[str]
    """The aliases that it discriminates from the error."""

    _keys = frozenset(["by", "is", "motion", "tells"])


class StaticFile(Node):
    """Attitude at rest."""

    heading_deg: float
    """Clockwise from north, degrees."""
    pitch_deg: float
    """Nose up, degrees."""
    roll_deg: float
    """Right side down, degrees."""

    _keys = frozenset(["heading_deg", "pitch_deg", "roll_deg"])


class StepReport(Node):
    """The evidence with some effects in the model."""

    global_p: float | None
    """Probability of what is left by chance."""
    p: float | None
    """Its probability by chance among all that was tried."""
    strongest: str | None
    """The strongest further candidate."""
    t: float | None
    """Its t."""
    with_: list[str]
    """Effects in the model."""

    _keys = frozenset(["global_p", "p", "strongest", "t", "with"])


class SwingFile(Node):
    """A swing: `mean + amplitude sin(2 pi t / period + phase)` in each angle."""

    heading: OscillationFile | None
    """Clockwise, as every heading: from north, under way from the course."""
    pitch: OscillationFile
    """Nose up."""
    roll: OscillationFile
    """Right side down."""
    yaw: OscillationFile | None
    """The same counter-clockwise, instead of `heading`."""

    _keys = frozenset(["heading", "pitch", "roll", "yaw"])


class UnexplainedNavigationReport(Node):
    """What nothing explains."""

    cells: list[NavigationCellReport]
    """Mean gap by channel and part of a run, the most significant first."""
    nearest: list[str]
    """The errors that come nearest together; they are not accepted."""
    nearest_explains: float
    """Share of the residual sum of squares that those would remove."""
    pattern: str
    """In one sentence."""

    _keys = frozenset(["cells", "nearest", "nearest_explains", "pattern"])

NavigateDiagnoseVerdict: TypeAlias = Literal["effects-found", "partly-explained", "nothing-missing", "unexplained", "not-diagnosable"]
"""The verdict."""


class NavigateDiagnoseReport(Report):
    """What `tumble diagnose MISSION --measured F --json` writes."""

    candidates: int
    """How many error sources were tried."""
    channels: list[ChannelReport]
    """The gap by run and channel, in the channel's own unit."""
    distinct_candidates: int
    """How many of them are distinct in these data: the number of tests that every p accounts for."""
    effects: list[NavigationEffectReport]
    """The errors that are missing from the mission, the strongest first."""
    gap: GapsReport
    """The gap (measured minus predicted) before and after, in standard uncertainties (where the mission has random walks: of innovations, so
    that they are independent); `noise.sd` is null, `channels` has that of each."""
    gap_steps: list[NavigationGapStepReport] | None
    """The gap as it shrinks: before, after the cause that reduces it most, after that and the next, ..., each set fitted anew; the last with
    single values left out. Empty where nothing was found."""
    invisible: list[str]
    """Error sources that these data cannot show at any size that a navigator's unit has."""
    left_out: int
    """Rows of the file that belong to other scenarios and were left out."""
    mission: str
    """The mission's title."""
    model_after: dict[str, QuantityWithUnit]
    """The same with what was found."""
    model_before: dict[str, QuantityWithUnit]
    """The mission's errors as given."""
    refits: int
    """How often what was found was put into the full simulation and refitted."""
    report: ReportKind
    """Always `navigate-diagnose`."""
    runs: list[RunReport]
    """The runs that were measured."""
    settled: bool
    """Whether the refits settled."""
    significance: float
    """Probability of reporting anything when nothing is missing."""
    state: State | None
    """What the posterior says: `nothing` is missing, an error at least is `named`, none is and one at least is `suspected`, or what is missing
    is `outside` of what was tried; absent where nothing can be diagnosed."""
    steps: list[StepReport]
    """The search's record."""
    suspected: list[SuspectReport] | None
    """Errors that are probable, but not enough for a name: no part of `model_after`."""
    suspects: list[NavigationSuspectReport]
    """Single values that noise does not explain after all that was found, the furthest first."""
    tumble: str
    """Version of the program that wrote it."""
    unexplained: UnexplainedNavigationReport | None
    """What is unexplained (beside what was found); null unless the verdict says so."""
    verdict: NavigateDiagnoseVerdict
    """`effects-found`, `partly-explained` (effects were found, and unexplained residuals remain), `nothing-missing`, `unexplained`, or
    `not-diagnosable` (fewer than three values)."""

    _keys = frozenset(["candidates", "channels", "distinct_candidates", "effects", "gap", "gap_steps", "invisible", "left_out", "mission", "model_after", "model_before", "refits", "report", "runs", "settled", "significance", "state", "steps", "suspected", "suspects", "tumble", "unexplained", "verdict"])


class CarriedReport(Node):
    """A covariance carried along one motion."""

    draws: int
    """Draws of the Monte Carlo run."""
    linear: ErrorReport | None
    """Standard uncertainties at the last row, linear covariance."""
    monte_carlo: ErrorReport | None
    """Standard deviation of the draws about zero at the last row."""
    motion: str
    """The motion."""
    position_u_m: list[float]
    """Standard uncertainty of position (east and north together), m, at these times."""
    time_h: list[float]
    """Times, h."""

    _keys = frozenset(["draws", "linear", "monte_carlo", "motion", "position_u_m", "time_h"])


class ErrorReport(Node):
    """A navigation error, or the standard uncertainty of one."""

    phi_arcsec: list[float | None]
    """`phi` about east, north, up, arcsec."""
    position_m: list[float | None]
    """East, north, m."""
    velocity_m_s: list[float | None]
    """East, north, m/s."""

    _keys = frozenset(["phi_arcsec", "position_m", "velocity_m_s"])


class PeriodsReport(Node):
    """Periods of the error equations."""

    earth_h: float
    """The Earth's rotation, h."""
    foucault_h: float | None
    """The Foucault rotation of Schuler's oscillation, `2 pi / (W sin L)`, h; null at the equator, where there is none."""
    schuler_min: float
    """Schuler's oscillation, min."""

    _keys = frozenset(["earth_h", "foucault_h", "schuler_min"])


class RatioReport(Node):
    """Ratios of one scenario; null where the first motion has no such error."""

    against: str
    """The motion that it is compared with."""
    azimuth: float | None
    """Azimuth, a ratio."""
    motion: str
    """The motion compared."""
    position: float | None
    """Position, a ratio."""
    scenario: str
    """The scenario."""
    tilt: float | None
    """Tilt, a ratio."""
    velocity: float | None
    """Velocity, a ratio."""

    _keys = frozenset(["against", "azimuth", "motion", "position", "scenario", "tilt", "velocity"])


class ResultReport(Node):
    """One scenario in one motion."""

    azimuth_arcsec: SummaryReport
    """Azimuth error, arcsec."""
    last: ErrorReport
    """The last row."""
    motion: str
    """The motion."""
    position_m: SummaryReport
    """Horizontal position error, m."""
    scenario: str
    """The scenario."""
    tilt_arcsec: SummaryReport
    """Tilt, arcsec."""
    time_h: float
    """Time of the last row, h."""
    velocity_m_s: SummaryReport
    """Horizontal velocity error, m/s."""

    _keys = frozenset(["azimuth_arcsec", "last", "motion", "position_m", "scenario", "tilt_arcsec", "time_h", "velocity_m_s"])


class ScenarioReport(Node):
    """A scenario."""

    errors: dict[str, QuantityWithUnit]
    """What is not zero."""
    id: str
    """Its name."""

    _keys = frozenset(["errors", "id"])


class SummaryReport(Node):
    """A quantity over all rows of a run."""

    last: float | None
    """At the last row, in the unit of its key."""
    max: float | None
    """Largest, in the unit of its key."""
    rms: float | None
    """Root mean square, in the unit of its key."""

    _keys = frozenset(["last", "max", "rms"])


class NavigateReport(Report):
    """What `tumble navigate --json` writes. Numbers of a navigator that ran over a pole are null."""

    carried: list[CarriedReport] | None
    """A calibration's covariance, carried to navigation errors."""
    convention: str
    """What the attitude errors are."""
    duration_h: float
    """Duration, h."""
    periods: PeriodsReport | None
    """The periods of the error equations at rest; null where their eigenvalues cannot be found."""
    ratios: list[RatioReport]
    """Root mean square errors of each motion over those of the first one."""
    report: ReportKind
    """Always `navigate`."""
    results: list[ResultReport]
    """Each scenario in each motion."""
    scenarios: list[ScenarioReport]
    """The scenarios' errors, in the unit of each."""
    step_s: float
    """Step, s."""
    title: str
    """The mission's title."""
    tumble: str
    """Version of the program that wrote it."""
    vertical_channel: str
    """What is held and not navigated."""
    warnings: list[str] | None
    """Motions beyond what the navigator's step resolves."""

    _keys = frozenset(["carried", "convention", "duration_h", "periods", "ratios", "report", "results", "scenarios", "step_s", "title", "tumble", "vertical_channel", "warnings"])


class AgreementReport(Node):
    """Agreement of the fitted coefficients with the Allan variances."""

    change: NoiseChangeReport | None
    """The largest change, where noise of these coefficients makes one as large in fewer than 1 of 10,000 records."""
    chi_square: float
    """Generalized sum of squares."""
    describes: bool | None
    """Do they describe them (a probability of at least 1 %)?"""
    dof: int
    """Degrees of freedom."""
    from_tau_s: float | None
    """The first averaging time that they describe, s, where shorter ones are left out."""
    p: float
    """Probability of more."""
    walk_sampled_s: float | None
    """The sampling interval, s, where a rate random walk was taken as sampled at the ends of the intervals rather than averaged over each: its
    Allan variance is then larger by `K^2 dt^2 / (6 tau)`. Which of the two a logger does is not known; the one that needs less to be
    described was taken."""

    _keys = frozenset(["change", "chi_square", "describes", "dof", "from_tau_s", "p", "walk_sampled_s"])


class NoiseChangeReport(Node):
    """A difference of neighbouring means that is no noise: the sensor moved, or its output jumped."""

    by: float
    """The second mean less the first, in the column's unit."""
    in_sd: float
    """The same in standard deviations of the difference, `sqrt(2)` Allan deviations of the fitted coefficients."""
    tau_s: float
    """The length of each of the two means, s."""
    time_s: float
    """When, in s from the record's beginning."""

    _keys = frozenset(["by", "in_sd", "tau_s", "time_s"])


class CoefficientReport(Node):
    """A coefficient of IEEE Std 952."""

    below: float | None
    """Where it is not found: what it is below (95 %), in `unit`."""
    id: Term
    """Its letter."""
    name: str
    """Its name."""
    p: float | None
    """Probability of as much if it were zero."""
    si_seconds: float | None
    """Value in the column's unit and seconds."""
    u: float | None
    """Standard uncertainty, in `unit`."""
    unit: str
    """The field's unit."""
    value: float | None
    """Value in `unit`; null where the record does not show it."""

    _keys = frozenset(["below", "id", "name", "p", "si_seconds", "u", "unit", "value"])


class DeviationReport(Node):
    """One deviation with its chi-square interval."""

    differences: int
    """Differences averaged."""
    edf: float
    """Equivalent degrees of freedom."""
    high: float | None
    """Upper end, in the same unit."""
    low: float | None
    """Lower end of its interval, in the same unit."""
    value: float
    """The deviation, in the column's unit."""

    _keys = frozenset(["differences", "edf", "high", "low", "value"])


class DeviationsReport(Node):
    """Deviations at one averaging time."""

    allan: DeviationReport
    """Overlapping Allan deviation."""
    alpha: int
    """Power of the frequency in the spectral density that dominates here: 2 (quantization), 0 (white), -1 (flicker), -2 (random walk)."""
    fitted: float | None
    """Allan deviation of the fitted coefficients, in the column's unit."""
    hadamard: DeviationReport | None
    """Overlapping Hadamard deviation."""
    m: int
    """Samples averaged."""
    modified: DeviationReport | None
    """Modified Allan deviation."""
    tau_s: float
    """Averaging time, s."""

    _keys = frozenset(["allan", "alpha", "fitted", "hadamard", "m", "modified", "tau_s"])


class NoiseColumnReport(Node):
    """The noise of one column."""

    agreement: AgreementReport | None
    """How well the coefficients describe the Allan variances."""
    coefficients: list[CoefficientReport]
    """Coefficients of IEEE Std 952."""
    column: str
    """The column's name."""
    left_out: dict[str, int] | None
    """Samples that were left out as if they were missing, by what is odd in them."""
    level: float
    """Probability of the intervals."""
    mean: float | None
    """Mean of all samples, in `unit`."""
    points: list[DeviationsReport]
    """Deviations."""
    samples: int
    """Samples."""
    scatter: list[NoiseScatterReport]
    """What a campaign may state about this sensor (its `scatter`)."""
    stretches: int
    """Stretches between gaps."""
    unit: str
    """Its unit."""
    without: Without | None
    """Why there are none."""

    _keys = frozenset(["agreement", "coefficients", "column", "left_out", "level", "mean", "points", "samples", "scatter", "stretches", "unit", "without"])


class NoiseScatterReport(Node):
    """A line for a campaign's `scatter`."""

    of: str
    """The sensor."""
    over: str | None
    """`time_s` for noise with memory."""
    per: str | None
    """`reading` for noise without memory."""
    tau: float | None
    """Its correlation time, s."""
    u: float
    """Standard deviation of one sample, in `unit`."""
    unit: str
    """Unit."""

    _keys = frozenset(["of", "over", "per", "tau", "u", "unit"])

Term: TypeAlias = Literal["Q", "N", "B", "K", "R"]
"""A coefficient's kind, by its letter in IEEE Std 952, from short to long averaging times."""

Without: TypeAlias = Literal["constant", "short", "undescribed"]
"""Why a record has no coefficients."""


class NoiseReport(Report):
    """What `tumble noise --json` writes."""

    columns: list[NoiseColumnReport]
    """One entry for each column."""
    interval_from: str
    """Where the sampling interval comes from: a column, or the rate as stated."""
    interval_s: float
    """Sampling interval, s."""
    record: str
    """The record."""
    report: ReportKind
    """Always `noise`."""
    tumble: str
    """Version of the program that wrote it."""

    _keys = frozenset(["columns", "interval_from", "interval_s", "record", "report", "tumble"])


class AlikeReport(Node):
    """Effects that cannot be distinguished."""

    first: int
    """The plainest, as an index into `effects`, from 0."""
    members: list[str]
    """Regressors, the plainest first."""
    near: list[NearReport]
    """Groups for which an effect of the smallest size could be taken."""

    _keys = frozenset(["first", "members", "near"])


class ComparisonReport(Node):
    """One line of the comparison."""

    better: float | None
    """With the better schedule, in `unit`."""
    equal_effort: float | None
    """With the given schedule repeated, or cut, to the effort of the better one: `u sqrt(effort given / effort better)`, in `unit`."""
    gain: float | None
    """`equal_effort / better`, a ratio."""
    given: float | None
    """Predicted uncertainty with the given schedule, in `unit`."""
    id: str
    """Parameter or derived quantity."""
    unit: str
    """Unit of the uncertainties: arcsec for angles."""

    _keys = frozenset(["better", "equal_effort", "gain", "given", "id", "unit"])


class CorrelationReport(Node):
    """Correlations."""

    matrix: list[list[float | None]]
    """Correlation coefficients, -1 to 1."""
    order: list[str]
    """Parameters, in the order of rows and columns."""

    _keys = frozenset(["matrix", "order"])


class DiscriminationReport(Node):
    """Two effects, and how well their coefficients are known with both in the model."""

    after: list[float | None]
    """Standard uncertainties with the added positions, in each coefficient's unit."""
    before: list[float | None]
    """Standard uncertainties before, in each coefficient's unit; null where nothing distinguishes them."""
    effects: list[str]
    """Regressors."""

    _keys = frozenset(["after", "before", "effects"])

Effort: TypeAlias = Literal["readings", "cost"]
"""What effort is counted in."""

Fate: TypeAlias = Literal["detectable", "absorbed", "not-exercised"]
"""What becomes of an effect on this schedule."""


class FindReport(Node):
    """An effect that is to be found, as a limit on the uncertainty of its coefficient."""

    coefficient: str
    """Its coefficient in the model of this plan."""
    effect: str
    """The effect."""
    power: float
    """Probability of finding it."""
    size: float
    """The size that is to be found (radians for tilts)."""
    u: float
    """The limit, in the coefficient's unit: the size over the noncentrality of that power."""

    _keys = frozenset(["coefficient", "effect", "power", "size", "u"])


class ForesightReport(Node):
    """What a diagnosis could find on a schedule."""

    effects: list[ProspectReport]
    """Every effect of the catalogue that this bench and these columns allow."""
    groups: list[AlikeReport]
    """Effects that this schedule cannot distinguish, the most plausible first; most groups have one member."""
    passed_over: list[PassedOverReport]
    """Families of effects that were passed over, with the columns that the schedule lacks for them."""
    rule: RuleReport
    """The rule behind every smallest size."""

    _keys = frozenset(["effects", "groups", "passed_over", "rule"])


class GoalReport(Node):
    """Whether a goal was reached."""

    impossible: list[str]
    """Limited quantities that even all candidates together do not determine."""
    is_cheapest_found: bool
    """Was the cheapest schedule sought? It is the cheapest that was found, without a proof that none is cheaper."""
    is_fewest: bool
    """Is it proven that no fewer readings of these candidates reach the goal?"""
    largest_share: float | None
    """Largest uncertainty as a share of its limit."""
    limits: dict[str, float]
    """Limit of each parameter and derived quantity that is counted, in its unit (arcsec for angles)."""
    reached: bool
    """Are all limits kept? If not, this schedule is the best reachable with so many readings."""

    _keys = frozenset(["impossible", "is_cheapest_found", "is_fewest", "largest_share", "limits", "reached"])


class ImprovedReport(Node):
    """The better schedule."""

    bound_gap: float | None
    """How loose that bound may be, as a share; a larger shortfall means that so few portions cannot follow the best weights."""
    budget: float | None
    """What could be spent on what was chosen, if there was a budget, in the unit of the costs."""
    candidates: int
    """Portions that could be chosen."""
    check: float | None
    """From the rows of the final schedule against the exchange's updates, as a relative difference for each unknown."""
    chosen: int
    """Readings that were chosen; others were kept."""
    comparison: list[ComparisonReport]
    """Per parameter and derived quantity: the given schedule, at equal effort, and the better one."""
    cost_limit: float | None
    """What the chosen ones might cost at most, where that was limited, in the unit of the costs."""
    criterion: str
    """`D`, `A`, `G`, `c:<quantity>`, `goal` or `T:<effect>|<effect>`."""
    efficiency: float | None
    """At least this share of the best possible choice of these candidates (within the budget, where there is one); null where no bound is
    known (goal, two effects)."""
    effort: Effort
    """What effort is counted in when schedules are compared: `readings`, or `cost` where there was a budget."""
    enumerated: int | None
    """Designs that there are, where all of them were tried: none is better."""
    frozen: dict[str, float]
    """Columns that differ in the given schedule and have one value in all candidates, with that value."""
    goal: GoalReport | None
    """The goal, if one was set."""
    hits: int
    """Starts that ended at this schedule's value."""
    judgement: JudgementReport
    """How well it will do."""
    kept: int
    """The first so many readings were kept, in their order."""
    positions: list[PlannedPositionReport]
    """The positions still to be measured, in the order to run, as reading keys."""
    reasons: list[ReasonReport]
    """Why each chosen mounting is there."""
    refined: RefinedReport | None
    """What moving the angles between the candidates brought; absent where that was not asked for. Efficiency and enumeration are those of the
    choice among the candidates."""
    seed: int
    """Seed that gives the same schedule again."""
    separation: DiscriminationReport | None
    """The two effects to be discriminated, if two were named."""
    shared: list[SharedReport] | None
    """Lines of scatter by which the chosen positions share deviations, and the levels that they are planned for."""
    starts: int
    """Starts of the exchange."""
    to_run: WorkReport
    """Work that is still to be done: without what has been measured."""
    unreachable: list[NotEstimableReport]
    """What even all candidates together do not determine."""

    _keys = frozenset(["bound_gap", "budget", "candidates", "check", "chosen", "comparison", "cost_limit", "criterion", "efficiency", "effort", "enumerated", "frozen", "goal", "hits", "judgement", "kept", "positions", "reasons", "refined", "seed", "separation", "shared", "starts", "to_run", "unreachable"])


class JudgementReport(Node):
    """How well a schedule will do."""

    bounds_not_counted: int
    """Bounds of the campaign, which are not counted: a bound lowers an uncertainty only where it is reached."""
    condition: float | None
    """Condition number of the scaled rows."""
    correlation: CorrelationReport
    """Correlations of the estimated parameters; null where one is not estimable."""
    derived: list[PredictedDerivedReport]
    """Predicted uncertainty of each derived quantity."""
    dof: int
    """Values minus rank."""
    drift: float | None
    """Largest shift of a parameter, as a share of its uncertainty, when a reading drifts by one standard deviation over the run."""
    effects: ForesightReport | None
    """What a diagnosis could find; null with more than 100,000 values."""
    lacking: LackingReport | None
    """What vanishes at the point of judging and needs a value; null where nothing does."""
    not_estimable: list[NotEstimableReport]
    """What only combinations determine, with the position that would separate it."""
    parameters: list[PredictedReport]
    """Predicted uncertainty of each estimated parameter."""
    rank: int
    """Independent combinations of the estimated parameters that it determines."""
    readings: list[PlannedReadingReport]
    """Every value of the schedule: leverage, minimal detectable bias and its effect; empty with more than 20,000 values."""
    through_tilts: ThroughTiltsReport | None
    """What known inputs do through tilts whose size a plan does not know; null where they do nothing."""
    unchecked: int
    """Values that no other value checks."""
    work: WorkReport
    """Readings, mountings, rate changes, cost."""

    _keys = frozenset(["bounds_not_counted", "condition", "correlation", "derived", "dof", "drift", "effects", "lacking", "not_estimable", "parameters", "rank", "readings", "through_tilts", "unchecked", "work"])


class LackingReport(Node):
    """What cannot be predicted at the point of evaluation although it could be nearby."""

    needs: list[str]
    """Parameters without a stated value on which these uncertainties depend."""
    untold: list[str]
    """Parameters whose uncertainty cannot be predicted."""

    _keys = frozenset(["needs", "untold"])


class MovesReport(Node):
    """The parameter that an effect of the smallest size shifts most."""

    in_u: float
    """Size of the shift in standard uncertainties of the parameter."""
    parameter: str
    """The parameter."""

    _keys = frozenset(["in_u", "parameter"])


class NearReport(Node):
    """A group that is nearly alike."""

    apart_from: float
    """Size of the first effect of this group from which it is not taken for the other, in its coefficient's unit."""
    cosine: float
    """Cosine of the angle between the two after projection on the model, -1 to 1."""
    group: int
    """The other group, from 0."""
    regressor: str
    """First regressor of the other group."""

    _keys = frozenset(["apart_from", "cosine", "group", "regressor"])

NoiseSource: TypeAlias = Literal["given", "stated", "residuals"]
"""Where the noise comes from."""


class PassedOverReport(Node):
    """A family of effects that was passed over."""

    name: str
    """Its name."""
    needs: list[str]
    """Columns that the schedule lacks."""

    _keys = frozenset(["name", "needs"])


class PlannedPositionReport(Node):
    """One position to run."""

    at: dict[str, float]
    """Reading keys."""
    levels: dict[str, str] | None
    """Values of the columns by which positions share deviations: the day, the operator."""
    position: str
    """Label of the mounting."""

    _keys = frozenset(["at", "levels", "position"])


class PlannedReadingReport(Node):
    """One value of a schedule."""

    at: dict[str, float]
    """The position as reading keys."""
    effect: dict[str, float]
    """What a bias of that size does to each estimated parameter, in its unit."""
    effect_arcsec: dict[str, float]
    """The same in arcseconds, for tilts."""
    index: int
    """Number of the reading, from 1."""
    leverage: float
    """Leverage, 0 to 1; near 1, nothing checks this reading."""
    mdb: float | None
    """Minimal detectable bias (significance 0.1 %, power 80 %), in the sensor's unit; null where nothing checks this reading."""
    position: str
    """Its label."""
    sensor: str
    """Sensor."""
    u: float
    """Standard uncertainty that was assumed, in the sensor's unit."""

    _keys = frozenset(["at", "effect", "effect_arcsec", "index", "leverage", "mdb", "position", "sensor", "u"])


class PointReport(Node):
    """Value of one estimated parameter at which schedules are judged."""

    arcsec: float | None
    """The same in arcseconds, for tilts."""
    from_: PointSource
    """`given` (--at), `fitted` (from the campaign's readings), `start`, `prior`, or `zero` where nothing is stated."""
    id: str
    """The parameter."""
    unit: str
    """Unit."""
    value: float
    """Its value, in `unit`."""

    _keys = frozenset(["arcsec", "from", "id", "unit", "value"])

PointSource: TypeAlias = Literal["given", "fitted", "start", "prior", "zero"]
"""Where a value of the point comes from."""


class PredictedDerivedReport(Node):
    """Prediction for one derived quantity."""

    id: str
    """Its name."""
    is_largest: bool
    """It has no derivative at the reference point, and this is the largest close by."""
    line: str
    """Its line of algebra."""
    u: float | None
    """Predicted standard uncertainty, in `unit`; null where not estimable, or where it depends on values that are not known."""
    u_arcsec: float | None
    """The same in arcseconds, for angles."""
    unit: str | None
    """Its unit, as asked for or as the line has it; absent where a parameter in it has none."""

    _keys = frozenset(["id", "is_largest", "line", "u", "u_arcsec", "unit"])


class PredictedReport(Node):
    """Prediction for one parameter."""

    from_known: float
    """The part from known inputs, in `unit`."""
    from_readings: float | None
    """The part from noise and remounting, in `unit`."""
    id: str
    """Its name."""
    kind: Kind
    """`tilt` or `coefficient`."""
    u: float | None
    """Predicted standard uncertainty, in `unit`; null where not estimable."""
    u_arcsec: float | None
    """The same in arcseconds, for tilts."""
    undetected_fault: float | None
    """The most that one bad value does to it, of a size that is just not detected, in `unit`; null where nothing checks any value."""
    undetected_fault_arcsec: float | None
    """The same in arcseconds, for tilts."""
    unit: str
    """Unit of `u`."""

    _keys = frozenset(["from_known", "from_readings", "id", "kind", "u", "u_arcsec", "undetected_fault", "undetected_fault_arcsec", "unit"])


class ProspectReport(Node):
    """One effect on a schedule."""

    at_a_reading: float | None
    """The most that an effect of this size changes a value, in the sensor's unit."""
    at_a_reading_in_u: float | None
    """The same in standard uncertainties of the value."""
    fate: Fate
    """`detectable`, `absorbed` (the estimated parameters take it up) or `not-exercised` (zero at every position)."""
    group: int | None
    """Its group, from 0; null unless detectable."""
    hides_in: list[str]
    """Parameters that take part in hiding an absorbed effect, the strongest first."""
    left: float
    """Share of its column that the model leaves, 0 to 1."""
    minimal: float | None
    """Smallest size that shows, in `unit`."""
    minimal_arcsec: float | None
    """The same in arcseconds, for angles."""
    moves: MovesReport | None
    """The estimated parameter that it shifts most against its u while it is not in the model."""
    name: str
    """Name in the field's words."""
    regressor: str
    """The term without its coefficient."""
    sensor: str | None
    """Sensor that would have it; null for what is common to all."""
    shifts: dict[str, float]
    """Shift of each estimated parameter for coefficient 1, in the parameter's unit (rad for tilts)."""
    u: float | None
    """Standard uncertainty of the coefficient estimated together with the others, in `unit`; null unless detectable."""
    unit: str
    """Unit of the coefficient; may be empty."""

    _keys = frozenset(["at_a_reading", "at_a_reading_in_u", "fate", "group", "hides_in", "left", "minimal", "minimal_arcsec", "moves", "name", "regressor", "sensor", "shifts", "u", "unit"])


class ReasonReport(Node):
    """What would be lost without one mounting."""

    grows: float | None
    """By what factor its uncertainty would grow; null where nothing would determine it."""
    parameter: str
    """The parameter that would lose most."""
    position: str
    """Label of the mounting."""

    _keys = frozenset(["grows", "parameter", "position"])


class RefinedReport(Node):
    """Angles moved between the candidates."""

    finished: bool
    """Did it end because no move was worth it? Else because of the effort."""
    gain: float
    """By what share the criterion is better: the determinant for each unknown (D), a variance (else)."""
    moved: int
    """Mountings with an angle that no candidate has."""
    resolution_deg: float
    """Angles were moved in multiples of this, in degrees."""

    _keys = frozenset(["finished", "gain", "moved", "resolution_deg"])


class RuleReport(Node):
    """The rule behind every smallest size: `minimal = noncentrality u`."""

    noncentrality: float
    """`z(1 - a/2) + z(power)` with `a` the level of one test (Sidak), a pure number; the noise is known."""
    power: float
    """Probability of seeing an effect of the smallest size."""
    significance: float
    """Probability of naming anything when nothing is missing, over all tests."""
    tests: int
    """Distinct directions: tests that are made."""
    with_residuals: float | None
    """The same if the noise is known from the residuals only; null with too few degrees of freedom."""

    _keys = frozenset(["noncentrality", "power", "significance", "tests", "with_residuals"])


class SensorNoiseReport(Node):
    """Noise of one sensor."""

    from_: NoiseSource
    """`given`, `stated` (in the readings) or `residuals` (of a fit to the readings)."""
    sd: float
    """Standard deviation of one reading, in `unit`."""
    unit: str
    """Its unit."""

    _keys = frozenset(["from", "sd", "unit"])


class SharedReport(Node):
    """Deviations that chosen positions share."""

    column: str
    """The column of the levels."""
    levels: list[str]
    """Its values at the chosen positions."""
    line: str
    """The line of scatter: `V per day`."""

    _keys = frozenset(["column", "levels", "line"])


class ThroughTiltsReport(Node):
    """What a known input's uncertainty does through the tilts."""

    counted: bool
    """Is it counted in the predicted uncertainties? Only where the size was stated."""
    known: str
    """The known input that matters most."""
    parameter: str
    """The parameter that it moves most."""
    tilts_arcsec: float
    """Size of the tilts in arcseconds: as stated, or an example."""
    u: float
    """Standard uncertainty from it, in the parameter's unit."""
    u_arcsec: float | None
    """The same in arcseconds, for tilts."""

    _keys = frozenset(["counted", "known", "parameter", "tilts_arcsec", "u", "u_arcsec"])


class WorkReport(Node):
    """Work of a schedule."""

    cost: float
    """Cost of it all, in the unit of the costs that were given (readings, where none were)."""
    mountings: int
    """Mountings."""
    rate_changes: int
    """Rate changes within mountings."""
    readings: int
    """Readings."""

    _keys = frozenset(["cost", "mountings", "rate_changes", "readings"])


class PlanReport(Report):
    """What `tumble plan --json` writes."""

    bench: str
    """Bench id."""
    finds: list[FindReport] | None
    """Effects that the schedule is asked to find."""
    identity: Identity | None
    """The unit under test, when, where, by whom, with what."""
    improved: ImprovedReport | None
    """The better schedule, if one was asked for."""
    judged_at: list[PointReport]
    """The value of each estimated parameter at which the schedules are evaluated."""
    model: dict[str, str]
    """Model line of each sensor."""
    noise: dict[str, SensorNoiseReport]
    """Noise of each sensor."""
    remount: dict[str, float]
    """Parameters that every remounting scatters, with the standard deviation (radians for tilts)."""
    report: ReportKind
    """Always `plan`."""
    schedule: JudgementReport
    """The schedule that was given."""
    tumble: str
    """Version of the program that wrote it."""

    _keys = frozenset(["bench", "finds", "identity", "improved", "judged_at", "model", "noise", "remount", "report", "schedule", "tumble"])


class DetectorReport(Node):
    """What the static detector judged by."""

    still_sd: dict[str, float | None]
    """Standard deviation of the still sensor, by column."""
    threshold: float
    """Largest variance of a still window, in variances of the still sensor."""
    window_s: float
    """Length of a window, s."""
    would_find: float | None
    """Where nothing was found: the threshold that would find the first stretch, in the same variances."""

    _keys = frozenset(["still_sd", "threshold", "window_s", "would_find"])

JumpKind: TypeAlias = Literal["back", "gap", "short"]
"""What a step of the times looks like, against the median step."""


class JumpReport(Node):
    """A step of the times that is none from one sample to the next."""

    kind: JumpKind
    """What it looks like."""
    row: int
    """Rows before it."""
    step_s: float
    """The step, s."""
    time_s: float
    """Time of the last of them, s since the first."""

    _keys = frozenset(["kind", "row", "step_s", "time_s"])


class RejectedReport(Node):
    """A stretch that did not become a reading."""

    end_s: float
    """Its end."""
    reason: str
    """Why."""
    start_s: float
    """Its first sample, s."""

    _keys = frozenset(["end_s", "reason", "start_s"])


class SegmentMeanReport(Node):
    """A mean."""

    apart: bool | None
    """Is its noise so different that u rests on it alone, or on segments like it? Absent where it is not."""
    column: str
    """The column."""
    dof: float | None
    """Degrees of freedom that the variance of the mean is known with."""
    effective_n: float
    """Samples without memory that would have the same uncertainty, a number of samples."""
    events: dict[str, int] | None
    """Events within the segment, by kind."""
    lag1: float
    """Correlation of neighbouring blocks of `lag_s`, -1 to 1."""
    lag_s: float
    """Length of such a block, s."""
    mean: float
    """Mean of the samples, in `unit`."""
    noisier: float
    """How much noisier than the other segments, as a ratio of standard deviations (1: not)."""
    sd: float
    """Standard deviation of the samples, in `unit`."""
    slope_p: float
    """Probability of so large a slope by chance, with the noise as found."""
    slope_per_s: float
    """Slope within the segment, per second, in `unit`."""
    slope_u: float
    """Its standard uncertainty, in the same unit."""
    sloping: bool | None
    """Is that below 1 %?"""
    u: float
    """Standard uncertainty, in `unit`: 1.96 u on either side covers 95 %; what learning the noise costs is in it, noise slower than the
    segment is not."""
    u_allan_floor: float
    """The Allan deviation at the segment's length, in `unit`."""
    u_autocorrelation: float
    """With the sum of the autocorrelations, in `unit`."""
    u_resolution: float
    """What rounding to the channel's steps leaves in the mean (in `u`, in quadrature), in `unit`."""
    u_white: float
    """What it would be for noise without memory, `s/sqrt(n)`, in `unit`."""
    unit: str
    """Its unit."""

    _keys = frozenset(["apart", "column", "dof", "effective_n", "events", "lag1", "lag_s", "mean", "noisier", "sd", "slope_p", "slope_per_s", "slope_u", "sloping", "u", "u_allan_floor", "u_autocorrelation", "u_resolution", "u_white", "unit"])


class SegmentReport(Node):
    """A segment."""

    end_s: float
    """Its end."""
    means: list[SegmentMeanReport]
    """The mean of each column."""
    n: int
    """Samples."""
    notes: list[str] | None
    """What a reader should know."""
    position: str
    """Its label; the position of its reading."""
    start_s: float
    """Its first sample, s since the first of the record."""

    _keys = frozenset(["end_s", "means", "n", "notes", "position", "start_s"])


class ReduceReport(Report):
    """What `tumble reduce --json` writes."""

    assumed_resolution: dict[str, float] | None
    """Columns that change in no segment, and the resolution that is assumed for each: the last decimal place of the values, 0 where their
    digits show none."""
    block: int
    """Samples to a block; segments begin and end with blocks."""
    by: str
    """How segments were found, in words."""
    clock_jumps: int | None
    """Other jumps of the clock: steps back, and steps much shorter than the sampling interval."""
    detector: DetectorReport | None
    """What the static detector judged by."""
    events: dict[str, dict[str, int]]
    """Events of the whole record, by column and kind."""
    gaps: int
    """Gaps in the times."""
    interval_s: float
    """Sampling interval, s."""
    jumps: list[JumpReport] | None
    """Gaps and jumps one by one, the first thousand."""
    record: str
    """The record."""
    rejected_: list[RejectedReport]
    """Stretches that did not."""
    report: ReportKind
    """Always `reduce`."""
    samples: int
    """Samples of each column."""
    segments: list[SegmentReport]
    """Segments that became readings."""
    tumble: str
    """Version of the program that wrote it."""

    _keys = frozenset(["assumed_resolution", "block", "by", "clock_jumps", "detector", "events", "gaps", "interval_s", "jumps", "record", "rejected", "report", "samples", "segments", "tumble"])


DistributionReport._parts = {"scattering": (BetweenReport, False)}
BatchReport._parts = {"chance": (ChanceReport, True), "conformity": (ConformityCounts, False), "devices": (DeviceCounts, False), "inputs": (Input, False), "lots": (LotReport, False), "noisy": (NoisyDeviceReport, False), "not_in_order": (NotInOrderReport, False), "outlying": (OutlyingReport, False), "quantities": (DistributionReport, False)}
CompareCalibrationsReport._parts = {"after": (CalibratedReport, False), "before": (CalibratedReport, False), "changes": (ChangeOfReport, False), "together": (TogetherReport, False)}
CompareHistoryReport._parts = {"calibrations": (CalibratedReport, False), "trends": (TrendReport, False)}
GroupReport._parts = {"quantities": (QuantityReport, False)}
Identity._parts = {"instruments": (Instrument, False), "unit": (UnitUnderTest, False)}
CompareReport._parts = {"all": (GroupReport, False), "groups": (GroupReport, False), "identity": (Identity, False), "inputs": (Input, False), "misprints": (MisprintReport, False)}
EffectReport._parts = {"aliases": (AliasReport, False), "gap_after": (GapReport, False), "in_sensors": (SensorSizeReport, False)}
GapStepReport._parts = {"gap": (GapReport, False)}
GapsReport._parts = {"after": (GapReport, False), "before": (GapReport, False), "noise": (DiagnoseNoiseReport, False), "sensors": (SensorGapReport, True)}
UnexplainedReport._parts = {"cells": (CellReport, False)}
DiagnoseReport._parts = {"constraints": (AssertedReport, False), "effects": (EffectReport, False), "gap": (GapsReport, False), "holdout": (HoldoutReport, False), "identity": (Identity, False), "inputs": (Input, False), "parameters": (ChangeReport, False), "residuals": (ResidualReport, False), "scatter": (ScatterReport, False), "steps": (GapStepReport, False), "suspected": (SuspectReport, False), "unexplained": (UnexplainedReport, False), "where": (PlaceReport, False)}
BinsReport._parts = {"bins": (BinReport, False)}
ChecksReport._parts = {"external": (ExternalReport, True), "follows": (FollowsReport, False), "lack_of_fit": (LackOfFitReport, False), "lack_of_fit_by_position": (LackOfFitReport, False), "normality": (NormalityReport, False), "runs": (RunsReport, True), "snooping": (SnoopingReport, False)}
CombinationValueReport._parts = {"arcsec": (ArcsecReport, False), "budget": (BudgetReport, False)}
ConformityReport._parts = {"quantities": (LimitedReport, False)}
ConstraintsReport._parts = {"equations": (EquationsReport, False), "list": (ConstraintReport, False)}
ConvergenceReport._parts = {"iterations": (IterationReport, False)}
CorrectionFile._parts = {"inputs": (InputFile, False), "mounting": (MountingFile, False), "parameters": (CorrectionParametersFile, False), "sensors": (CorrectedSensorFile, False), "validity": (ValidityFile, False)}
DerivedReport._parts = {"arcsec": (ArcsecReport, False), "budget": (BudgetReport, False)}
FitSummary._parts = {"inconsistent_circles": (CircleReport, False)}
MonteCarloReport._parts = {"joint": (JointReport, False), "outputs": (DrawnReport, False)}
NotEstimableReport._parts = {"estimable": (CombinationReport, False)}
ParameterReport._parts = {"arcsec": (ArcsecReport, False), "budget": (BudgetReport, False)}
RecordReport._parts = {"inputs": (BinsReport, False), "sensors": (RecordSensorReport, False)}
RecordSensorReport._parts = {"lags": (LagReport, False), "largest": (FarReport, False), "means": (MeansReport, False)}
SiteReport._parts = {"gravity": (GravityReport, False)}
SnoopingReport._parts = {"suspects": (FitSuspectReport, False)}
FitReport._parts = {"checks": (ChecksReport, False), "conditional": (ConditionalReport, False), "conformity": (ConformityReport, False), "constraints": (ConstraintsReport, False), "convergence": (ConvergenceReport, False), "correction": (CorrectionFile, False), "correlation": (CovarianceReport, False), "covariance": (CovarianceReport, False), "derived": (DerivedReport, False), "estimable_combinations": (CombinationValueReport, False), "fit": (FitSummary, False), "identity": (Identity, False), "inputs": (Input, False), "known": (KnownReport, False), "monte_carlo": (MonteCarloReport, False), "not_estimable": (NotEstimableReport, False), "parameters": (ParameterReport, False), "readings": (ReadingReport, False), "record": (RecordReport, False), "robust": (RobustReport, False), "scatter": (ScatterReport, False), "site": (SiteReport, False)}
GuideHeld._parts = {"means": (HeldMean, False)}
Lacks._parts = {"effects": (Named, False)}
Mistake._parts = {"explanations": (Explanation, False)}
GuideReport._parts = {"diagnosis": (Lacks, False), "goals": (Progress, False), "held": (GuideHeld, False), "mistake": (Mistake, False), "newest": (Newest, False), "next": (Next, False), "parameters": (Estimated, False), "residuals": (Residual, False), "suspected": (Suspected, False)}
LegsFile._parts = {"legs": (LegFile, False), "swing": (SwingFile, False)}
NavigationEffectReport._parts = {"aliases": (NavigationAliasReport, False), "separate_by": (SeparationReport, False)}
NavigationGapStepReport._parts = {"gap": (GapReport, False)}
SwingFile._parts = {"heading": (OscillationFile, False), "pitch": (OscillationFile, False), "roll": (OscillationFile, False), "yaw": (OscillationFile, False)}
UnexplainedNavigationReport._parts = {"cells": (NavigationCellReport, False)}
NavigateDiagnoseReport._parts = {"channels": (ChannelReport, False), "effects": (NavigationEffectReport, False), "gap": (GapsReport, False), "gap_steps": (NavigationGapStepReport, False), "model_after": (QuantityWithUnit, True), "model_before": (QuantityWithUnit, True), "runs": (RunReport, False), "steps": (StepReport, False), "suspected": (SuspectReport, False), "suspects": (NavigationSuspectReport, False), "unexplained": (UnexplainedNavigationReport, False)}
CarriedReport._parts = {"linear": (ErrorReport, False), "monte_carlo": (ErrorReport, False)}
ResultReport._parts = {"azimuth_arcsec": (SummaryReport, False), "last": (ErrorReport, False), "position_m": (SummaryReport, False), "tilt_arcsec": (SummaryReport, False), "velocity_m_s": (SummaryReport, False)}
ScenarioReport._parts = {"errors": (QuantityWithUnit, True)}
NavigateReport._parts = {"carried": (CarriedReport, False), "periods": (PeriodsReport, False), "ratios": (RatioReport, False), "results": (ResultReport, False), "scenarios": (ScenarioReport, False)}
AgreementReport._parts = {"change": (NoiseChangeReport, False)}
DeviationsReport._parts = {"allan": (DeviationReport, False), "hadamard": (DeviationReport, False), "modified": (DeviationReport, False)}
NoiseColumnReport._parts = {"agreement": (AgreementReport, False), "coefficients": (CoefficientReport, False), "points": (DeviationsReport, False), "scatter": (NoiseScatterReport, False)}
NoiseReport._parts = {"columns": (NoiseColumnReport, False)}
AlikeReport._parts = {"near": (NearReport, False)}
ForesightReport._parts = {"effects": (ProspectReport, False), "groups": (AlikeReport, False), "passed_over": (PassedOverReport, False), "rule": (RuleReport, False)}
ImprovedReport._parts = {"comparison": (ComparisonReport, False), "goal": (GoalReport, False), "judgement": (JudgementReport, False), "positions": (PlannedPositionReport, False), "reasons": (ReasonReport, False), "refined": (RefinedReport, False), "separation": (DiscriminationReport, False), "shared": (SharedReport, False), "to_run": (WorkReport, False), "unreachable": (NotEstimableReport, False)}
JudgementReport._parts = {"correlation": (CorrelationReport, False), "derived": (PredictedDerivedReport, False), "effects": (ForesightReport, False), "lacking": (LackingReport, False), "not_estimable": (NotEstimableReport, False), "parameters": (PredictedReport, False), "readings": (PlannedReadingReport, False), "through_tilts": (ThroughTiltsReport, False), "work": (WorkReport, False)}
ProspectReport._parts = {"moves": (MovesReport, False)}
PlanReport._parts = {"finds": (FindReport, False), "identity": (Identity, False), "improved": (ImprovedReport, False), "judged_at": (PointReport, False), "noise": (SensorNoiseReport, True), "schedule": (JudgementReport, False)}
SegmentReport._parts = {"means": (SegmentMeanReport, False)}
ReduceReport._parts = {"detector": (DetectorReport, False), "jumps": (JumpReport, False), "rejected": (RejectedReport, False), "segments": (SegmentReport, False)}
