# 报告用语(简体中文)。术语依据:JJF 1059.1、JJF 1001、GJB 2426A、GJB 1037A。参数在进入语句之前已经格式化。

## 列举与计数

list-and = { $before } 和 { $last }
count-reading = { $n } 个读数
count-prior = { $n } 个先验值
count-iteration = { $n } 次迭代
count-parameter = { $n } 个参数
count-degree = 自由度 { $n }
count-contribution = { $n } 个分量
count-step = { $n } 步
degrees-of-freedom = 自由度

## 报告的固定词汇

state-free = 自由
state-at-bound = 位于界限上
state-not-estimable = 不可估计
outcome-pass = 合格
outcome-fail = 不合格
outcome-undecided = 不能判定
estimator-exact = 精确
estimator-linear = 线性
distribution-normal = 正态
distribution-rectangular = 均匀
distribution-triangular = 三角
distribution-arcsine = 反正弦
distribution-t = t
from-stated = 给定
from-estimated = 估计
constraint-equality = 等式
constraint-inactive = 不起作用
constraint-active = 起作用
constraint-contradictory = 相互矛盾
constraint-not-applied = 未施加
side-lower = 下限
side-upper = 上限
side-norm = 范数

# report/fit_table.rs
tumble-fit-on = tumble { $tumble }：{ $bench } 的{ $estimator }拟合
derived = 导出量
parameter = 参数
estimate = 估计值
dof = 自由度
unit = 单位
state = 状态
rank-of-degrees-of-freedom = { $reading }{ $priors }，秩 { $rank }（参数 { $parameters } 个），自由度 { $dof }
fit-table-condition = ，条件数 { $condition }
rejected-the-readings-scatter-more-than-their = 拒绝：读数的分散程度超出所给不确定度
accepted = 接受
global-test-chi-square-with-degrees-of = 整体检验：χ² = { $chi_square }，自由度 { $dof }，p = { $p }，因子 { $sd }：{ $verdict }
that-of-rounding-to-its-last-digit = 取自修约到 { $step }（末位，除以 √12）：读数的分散不超过此值
the-rounding-of-its-readings-which-show = 取自读数的修约，读数未表现出分散
estimated-from-these-readings = 由本组读数估计
residual-sd-of = { $sensor } 的残差标准差：{ $sd }，{ $how }
residual-sd-of-none-no-degrees-of = { $sensor } 的残差标准差：无（自由度为零），因此不能给出不确定度
inconsistent-disagrees-with-the-other-sights-by = 不一致：{ $sensor } 与其余瞄准读数平均相差 { $mean_residual_deg } deg(瞄准了目标的另一面？瞄错了点？初值相差太远？)
fit-table-note = 注：{ $remark }
fit-table-known = 已知量：{ $known }
assumed-zero = 设为零：{ $assumed_zero }
note-one-linear-step-is-not-enough = 注：此处一步线性解不够：高斯-牛顿法还会使下列参数改变 0.1 u 以上：{ $differ }；请去掉 --linear 再拟合
no-reading-responds-to-at-the-reference = 在参考点处没有读数对 { $moved } 有响应（与其相乘的量全为零），故从参考点旁边开始迭代
held-where-the-iteration-began-since-the = 保持迭代初值，因为精确模型在其以外对下列参数的约束太弱：{ $held }
the-linear-estimates-linear-are-the-same = 线性估计值（--linear）与之相差不超过 0.1 u
the-linear-estimates-linear-differ-by-more = 线性估计值（--linear）与之相差超过 0.1 u(精确减线性)：{ $differ }
gauss-newton-converged-after = 高斯-牛顿法经 { $steps }收敛；{ $linear }
gauss-newton-not-converged-after = 高斯-牛顿法经 { $steps }仍未收敛（{ $stop }）
estimable-combination = 可估计的组合
u-holds-only-for-as-held-another = U 仅在 { $held } 保持现值时成立：将其改变 { $by } { $unit }，则 { $shifts } 随之改变
not-estimable-is-free = 不可估计：{ $text } 不受约束
no-reading-responds-to-it-at-this = 在该点没有读数对其有响应
no-reading-responds-to-it = 没有读数对其有响应
only-estimable-here = 此处只能估计 { $only }
a-reading-at-would-separate-it = 在 { $keys } 处增加一个读数即可将其分离
reading = 读数
position = 位置
sensor = 传感器
value = 量值
fitted = 拟合值
residual = 残差
studentized = 学生化残差
redundancy = 冗余数
mdb = 最小可探测偏差

# report/fit_checks_table.rs
combined = 合成
quantity = 量
type = 类别
distribution = 分布
contribution = 不确定度分量
share = 占比
budget-of = { $id }{ $unit } 的不确定度概算
correlation = 相关系数
less-than-half-weight-readings = ；权重降到一半以下的读数：{ $named }
fit-checks-table-constraints = 约束：{ $verdict }
is-at-a-bound-interval-to-of = { $id } 位于界限上：{ $level } % 区间为 { $low } 至 { $high } { $unit }（无约束估计的区间，截取容许部分）
is-at-a-bound-and-the-whole = { $id } 位于界限上，而无约束估计的 { $level } % 区间全部在容许范围之外：界限与读数不相容
yes = 是
monte-carlo = 蒙特卡洛法
mean = 均值
low = 下端
high = 上端
shortest-low = 最短区间下端
shortest-high = 最短区间上端
first-order-agrees = 一阶近似相符
trials-seed = { $trials } 次试验，随机种子 { $seed }
coverage-ellipsoid-of-k-p = { $order } 的包含椭球：k_p = { $k }

# report/correction.rs
the-lines-are-linear-in-the-inputs = 模型对输入量是线性的：此修正是精确的。
within-the-range-of-the-calibration-it = 在标定范围（{ $within }）内，剩余误差至多 { $errors }
below-the-standard-uncertainty-of-the-calibration = ，在该范围内处处小于标定的标准不确定度。
no-part = 0 %
within-of-that-range-it-stays-below = ；在该范围的 { $part } 以内小于标定的标准不确定度。超出时请用精确模型：`tumble apply` 即按精确模型修正。
the-exact-lines-tumble-apply-leave-nothing = ；用精确模型（`tumble apply`）则没有剩余误差。
correction-otherwise = { $id }（否则取 { $otherwise }{ $unit }）
these-sensors-do-not-determine-give-it = 这些传感器不能确定 { $given }：请在读数旁以一列给出。
correction-none-of-the-sensors-follows-a = 修正：没有传感器响应本拟合所能确定的角速率 w_* 或比力 a_*
correction-first-order-inputs-matrix-readings-bias = 一阶修正：输入量 = 矩阵 ×（读数 - 零偏）
input = 输入量
bias = 零偏
is-left-out = { $sensor } 未纳入：{ $why }。

# report/html/fit_page.rs
calibration-every-angle-and-coefficient-with-its = 标定结果：各角度与系数及其不确定度
made-by = 生成程序
tumble-the-same-inputs-give-the-same = tumble { $version }；相同的输入得到逐字节相同的输出
sha-of = { $name } 的 SHA-256
bench = 测试装置
source = 出处
campaign = 测试文件
model = 模型
one-least-squares-step-from-the-reference = 从参考点出发的一步最小二乘
gauss-newton-on-the-exact-rotations = 对精确旋转链的高斯-牛顿法
estimator = 估计方法
residuals-and-correlations = 残差与相关系数

# report/html/fit_answer.rs
result = 结论
not-everything-is-estimable-is-free-see = 有的参数不可估计：`{ $text }` 不受约束，见下文。
the-readings-scatter-more-than-their-stated = 读数的分散程度超出所给不确定度，模型有遗漏或不确定度给得过小
the-readings-scatter-as-their-stated-uncertainties = 读数的分散程度与所给不确定度相符
global-test-chi-square-with-p = 整体检验：{ $words }（χ² = { $chi_square }，{ $dof }，p = { $p }）。
the-readings-state-no-uncertainty-of-their = 读数未给出自身的不确定度：其分散由残差估计，只有重复读数能检验模型。
the-readings-state-no-uncertainty-of-their-2 = 读数未给出自身的不确定度：其分散由残差估计，因此仅凭这些读数不能检验模型。
no-degrees-of-freedom-the-readings-just = 自由度为零：读数恰好确定参数，无从检核。
the-readings-of-scatter-no-more-than = `{ $sensor }` 读数的分散不超过其末位所能显示的程度：u 取修约到 { $step } 所引入的不确定度。
one-linear-step-is-not-enough-gauss = 一步线性解不够：高斯-牛顿法还会使下列参数改变 0.1 u 以上：{ $what }。请去掉 `--linear` 再拟合。
converged = 收敛
did-not-converge = 未收敛
the-linear-estimates-one-step-from-the = 线性估计值（从参考点出发的一步）与之相差不超过 0.1 u。
the-linear-estimates-one-step-from-the-2 = 线性估计值（从参考点出发的一步）与之相差超过 0.1 u(精确减线性)：{ $differ }。
gauss-newton-after = 高斯-牛顿法经 { $steps }{ $word }{ $why }。{ $linear }
no-reading-responds-to-at-the-reference-2 = 在参考点处没有读数对 { $moved } 有响应（与其相乘的量全为零）：拟合从参考点旁边开始。
held-where-the-iteration-began-since-the-2 = 保持迭代初值，因为精确模型在其以外对下列参数的约束太弱：{ $held }。
u-holds-only-for-as-held-another-2 = U 仅在 `{ $held }` 保持现值时成立：将其改变 { $by }，则 { $shifts } 随之改变。
from-the-fit-estimates-rank-of-freedom = 由 { $from }估计 { $parameters }（秩 { $rank }，{ $dof }）。
at-every-angle-is-known-to-arcsec = 包含概率为 { $level } 时，各角度的扩展不确定度均为 { $high } arcsec。
at-the-angles-are-known-to-between = 包含概率为 { $level } 时，各角度的扩展不确定度在 { $low } arcsec(`{ $best }`)与 { $high } arcsec(`{ $worst }`)之间。
fit-answer-for = `{ $sensor }` 为 { $sd }
residual-standard-deviation = 残差标准差：{ $scatter }。
the-scaled-design-matrix-has-condition-number = 标度后的设计矩阵条件数为 { $condition }。

# report/html/fit_correction.rs
the-correction-to-apply = 修正公式
readings-cannot-be-corrected-not-estimable-here = 不能修正读数：{ $missing } 在此不可估计。
all-sensors-are-solved-together-for-the = 由全部传感器联立求解其所能确定的输入量。用本次标定的数值，一阶修正为：
is-left-out-of-the-correction = 修正未包含 `{ $sensor }`：{ $why }。
tumble-apply-corrects-a-record-by-the = `tumble apply` 按精确模型修正记录，`tumble export` 将其写成源代码；两者均读取本拟合的 JSON 报告。
the-rotation-from-the-sensors-axes-to = 从传感器轴到安装面的旋转需要 { $tilts }；其中 { $missing } 在此不可估计。
direction-cosines-of-the-corrected-inputs-on = 修正后输入量在安装面坐标系中的方向余弦
a-corrected-input-points-along-the-sensors = 修正后的输入量沿传感器自身的轴。相对于安装面（最后一个转轴之后的坐标系），这些轴转过了 { $tilts }；在安装面上已知的角速率或比力沿各轴的分量由下表给出：
belongs-to-the-bench-and-stays-there = { $others } 属于测试装置，不随器件带走。

# report/html/fit_estimates.rs
angle = 角度
coefficient = 系数
not-estimable = 不可估计
interval-to = ，区间 { $a } 至 { $b }
u-combined-standard-uncertainty-k-u-expanded = u：合成标准不确定度；{ $expanded } = k u：扩展不确定度，包含因子 k 由 t 分布按有效自由度 ν 得出。
estimates = 估计结果
not-estimable-from-these-readings = 由本组读数不可估计的量
only-determined = 只能确定 { $only }
the-parameters-can-move-along-and-no = 参数可沿 `{ $text }` 变动而读数不变；{ $instead }。
what-would-separate-it-a-further-reading = 分离办法：在 { $keys } 处增加一个读数。
fit-estimates-but = 但是，{ $nowhere }。
no-position-of-this-bench-would-separate = 本测试装置的任何位置都不能将其分离：需要另一种装置，或给定一个已知值。
determined-instead = 可确定的量
where-the-uncertainty-comes-from = 不确定度来源
source-2 = 来源
u-of-source = 来源的 u
angles-in-radians-c-sensitivity-coefficient-of = 角度以弧度计。c：单一来源的灵敏系数；ν：自由度；占比：在方差中所占的份额。
below-of-the-variance-left-out = 另有 { $contribution }小于方差的 0.05 %，未列出。

# report/html/fit_figures.rs
angles-with-their-expanded-uncertainties = 各角度及其扩展不确定度（{ $level }）。
fit-figures-arcsec = { $id } { $value } ± { $expanded } arcsec
standard-uncertainties-divided-by-each-sources-share = 标准不确定度，按各来源在方差中的占比划分。
u-arcsec = { $id }：u 为 { $u } arcsec，{ $bar }
standard-uncertainty = 标准不确定度
coefficients-each-sources-share-of-the-variance = 系数：各来源在方差中的占比。低于 0.5 % 的来源留白。
share-of-the-variance = 在方差中的占比
none-lies-beyond-standard-deviations = 没有读数超出 { $limit } 倍标准差。
diamonds-lie-beyond-standard-deviations-reading = 菱形表示超出 { $limit } 倍标准差的读数：第 { $far } 个。
diamonds-of-them-lie-beyond-standard-deviations = 菱形表示超出 { $limit } 倍标准差的读数，共 { $n } 个。
one-reading-in-is-drawn = 每 { $every } 个读数画出一个。
residuals-of-before-bands-of-two-standard = { $id } 的残差与两倍标准差带。{ $beyond }{ $thinned }
residuals-of = { $id } 的残差：{ $beyond }
fit-figures-residual = { $id } 残差
normal-plot-of-the-studentized-residuals-with = 学生化残差的正态概率图及逐点 95 % 带：残差服从正态分布时各点沿直线分布。
correlations-of-the-estimates-in-hundredths-blue = 估计值的相关系数（以百分之一计）：蓝色为正，橙色为负，叉号表示不可估计。
and-more-as-in-the-table = ；另有 { $lines } 项，见表
studentized-residuals-from-to = { $n } 个学生化残差，从 { $low } 到 { $high }。
no-correlation = 无相关。
strongest-correlation-between-and = 最强的相关：{ $a } 与 { $b } 之间为 { $r }。

# report/html/fit_readings.rs
taken-as-zero-neither-known-nor-estimated = 取为零，既非已知也未估计：{ $assumed_zero }。
gravity-g = 重力 { $gravity_g } g
site-latitude-earth-rate-deg-h = 测试地点：纬度 { $latitude_deg }°，地球自转角速率 { $earth_rate_deg_h } deg/h，{ $said }。
no-site-no-earth-rate-and-gravity = 未给测试地点：不计地球自转角速率，重力取 1 g。
fit-readings-warning = 警告：{ $warning }。
linear-rows-are-exact-derivatives-at-the = 线性：各行取参考点处的精确导数，由此走一步。
exact-rows-are-exact-derivatives-iterated-to = 精确：各行取精确导数，迭代至解。
uncertainties-of-the-readings-are-as-stated = 读数的不确定度按所给取用。
readings-of-one-sensor-scatter-alike-and = 同一传感器的读数分散程度相同且相互独立，其大小由残差得出。
entered-as-rows-of-their-own = { $prior }各作为一行参与平差。
known = 已知量
exact = 精确
what-was-assumed = 假设条件
detectable = 可探测偏差
redundancy-the-share-of-a-fault-that = 冗余数：粗差反映到该读数自身残差中的份额。可探测偏差：显著性水平 0.1 %、检验功效 80 % 时所能发现的最小粗差。带标记者：学生化残差超出 { $limit }。
the-first-of-are-listed-the-json = 共 { $n } 个读数，列出前 { $listed } 个；JSON 报告中有全部读数。
readings = 读数

# report/html/checks_page.rs
lack-of-fit-the-model-leaves-more = 失拟：模型的剩余大于重复读数的分散（p = { $p }）。
suspicious-see-the-checks = 可疑读数：第 { $numbers } 个，见检验部分。
the-robust-estimator-did-not-settle = 稳健估计（{ $method }）未收敛。
checks = 检验
test = 检验
statistic = 统计量
lack-of-fit = 失拟检验
f-with-and = F = { $f }，ν 为 { $between_dof } 和 { $pure_error_dof }
runs-of = `{ $sensor }` 的游程检验
runs-expected = 游程 { $runs } 个，期望 { $expected } 个
normality = 正态性
suspicious-reading = 可疑读数
shift = 偏移
shift-how-far-the-reading-is-off = 偏移：该读数偏离其余读数所示值的量。p：对全部 { $tested } 个读数而言（Sidak）。
weakest-reading = 最弱读数
effect = 影响
change-without-suspects = 剔除可疑读数后的变化
external-reliability = 外部可靠性
effect-what-the-smallest-detectable-fault-of = 影响：所列读数的最小可探测粗差若未被发现，对参数造成的影响。
constraints-and-weights = 约束与权
constraint = 约束
side = 侧
cost-in-chi-square = χ² 的增量
no-reading-lost-more-than-half-of = 没有读数的权降到一半以下。
less-than-half-of-their-weight-readings = 权降到一半以下的读数：{ $low }。
robust-estimator-of-reweighting = 稳健估计：{ $method }，重新定权 { $steps }。{ $down }
checks-page-interval = 包含区间（{ $level }）
shortest = 最短区间
first-order = 一阶近似
of-trials-seed = { $asked } 次试验中 { $trials } 次有效，随机种子 { $seed }。
marked-the-first-order-is-not-good = { $trials }带标记者：一阶近似达不到不确定度的两位有效数字。

# report/html/conformity_page.rs
conformity = 合格评定
lower-limit = 下限
upper-limit = 上限
probability = 合格概率
outcome = 结论
probability-that-the-quantity-is-inside-its = 合格概率：以估计值为中心按 t 分布计算的、量值在限内的概率（JCGM 106, 7.3）。

# report/html/scatter_page.rs
what-scatters = 分散性来源
sources-of-scatter = 分散性的各来源
sd-standard-deviation-of-one-deviation-a = 标准差：单次偏差的标准差。来源由测试文件给定，或由本组读数估计（限制最大似然法）；各来源在不确定度概算中均占一行。

# report/plot/normal.rs
normal-quantile = 正态分位数
studentized-residual = 学生化残差

# report/plot/values.rs
estimate-and-expanded-uncertainty = 估计值与扩展不确定度

# report/plot/bars.rs
bars-type = { $name }（{ $type_b } 类）

# report/html/compare_page.rs
least-squares-beside-the-published-closed-forms = 最小二乘与已发表闭式公式的比较
comparison-with-the-published-closed-forms = 与已发表闭式公式的比较
group-by-group-and-without-the-earth = 逐组比较且不计地球自转角速率（公式将其忽略）时，两者相差不超过量值的 { $difference }：公式是最小二乘的恰定特例。
group-by-group-and-without-the-earth-2 = 逐组比较且不计地球自转角速率（公式将其忽略）时，两者相差达量值的 { $difference }：这些位置不是公式的恰定情形。
mean-of-closed-forms = 闭式公式均值
least-squares-all-readings = 最小二乘（全部读数）
printed = 原文值
closed-form = 闭式公式
least-squares-no-earth-rate = 最小二乘（不计地球自转）
least-squares = 最小二乘
all = 全部
group-by-group = 逐组结果
what = 项目
computed = 计算值
what-seems-to-have-happened = 可能的原因
misprints-found = 发现的排印错误

# report/compare_table.rs
tumble-published-closed-forms-on = tumble { $tumble }：{ $bench } 的已发表闭式公式
printed-mean = 原文均值
closed-form-and-least-squares-without-earth = 闭式公式与不计地球自转的最小二乘相差达量值的 { $difference }：这些位置不是公式的恰定情形，公式只用了部分读数或权不同。
closed-form-and-least-squares-without-earth-2 = 闭式公式与不计地球自转的最小二乘相差至多为量值的 { $difference }：每一组内公式都是恰定特例。各行计入地球自转角速率后，最小二乘结果改变的量即最后两列之差；闭式公式将其忽略。
closed-form-and-least-squares-differ-by = 闭式公式与最小二乘相差至多为量值的 { $difference }。
misprints-that-this-comparison-finds = 比较中发现的排印错误：
printed-computed = 原文 { $printed }，计算 { $computed }：

# report/conformity.rs
conformity-2 = 合格评定
lower = 下限
upper = 上限
conformity-conformity = 合格评定：{ $outcome }；{ $rule }

# report/site.rs
site-warning = 警告：{ $warning }
at-latitude-deg-and-m = 纬度 { $latitude } deg，高程 { $altitude } m
stated = ，给定值
site-gravity = 重力加速度：{ $gravity } { $unit }{ $u }{ $from }
gravity-is-not-stated-and-taken-as = 未给出重力加速度，取 { $standard_gravity_m_s2 } m/s^2；当地重力加速度可相差达 3000 ppm，以 m/s^2 为单位的系数亦然：请给出 `site.gravity`，或 `site.latitude_deg` 与 `site.altitude_m`

# report/scatter.rs
scatter-tau = { $sd } { $unit },τ = { $tau }
estimated-zero = 估计：零
what-scatters-2 = 分散性来源
scatter-sd = 标准差
scatter-u-sd = u(标准差)
scatter-from = 取得方式
scatter-levels = 水平数
scatter-largest-share = 最大占比
scatter-share-of = { $id } 的 { $share } %
source-readings-of = { $sensor } 的读数
source-priors = 先验值
source-per = { $of }（按{ $per }）
source-over-per = { $of }（按{ $per }，随 { $over } 相关）
per-reading = 读数
per-position = 位置
per-campaign = 整次测试
source-note = { $source }：{ $note }
source-note-sentence = { $source }：{ $note }。
the-readings-scatter-no-more-than-without = 没有它读数的分散也不过如此：估计为零；u 与自由度并不依赖其为零
the-readings-scatter-no-more-than-without-2 = 没有它读数的分散也不过如此：估计为零
no-reading-feels-it-here = 此处没有读数受其影响
these-readings-cannot-tell-it-from-their = 这些读数不能将其与{ $others }分开：按两者之和处理；在同一水平上重复读数即可分开
these-readings-cannot-tell-it-from-the-rest = 这些读数不能将其与其余分散性来源分开：按两者之和处理；在同一水平上重复读数即可分开
joined-sources = { $before }和{ $other }
no-degrees-of-freedom-are-left-to = 没有剩余自由度用以估计
in-each-reading-as-stated = 各读数分别给定

# report/separation.rs
beyond-this-point-readings-respond-to-it = 离开该点读数才对其有响应，响应经由此处为零或与零难以区分的量：请给出一个值、先验值或初值
no-position-of-this-bench-would-separate-2 = 本测试装置的任何位置都不能将其分离
hides-in-and = { $last } 隐含在 { $join } 和 { $before } 之中

# report/fit_checks.rs
f-with-and-degrees-of-freedom-p = F = { $f }，自由度 { $between_dof } 和 { $pure_error_dof }，p = { $p }
lack-of-fit-the-model-leaves-more-2 = 失拟：模型的剩余大于重复读数的分散（{ $numbers }）；可试用 `tumble diagnose`
replicates-scatter-as-much-as-the-model = 重复读数的分散与模型的剩余相当（{ $numbers }）
residuals-of-have-too-runs-of-one = { $sensor } 残差的同号游程过{ $word }（{ $runs } 个，期望 { $expected } 个，p = { $p }）：存在漂移或交替变化
runs-few = 少
runs-many = 多
residuals-are-not-normal-shapiro-francia-w = 残差不服从正态分布（Shapiro-Francia W' = { $w }，p = { $p }）
suspicious-reading-of-is-off-what-the = 可疑：{ $sensor } 的第 { $index } 个读数偏离其余读数所示值 { $shift }（w = { $w }，对全部 { $tested } 个读数 p = { $p }）

# report/fit_constraints.rs
no-values-meet-constraints-together-none-was = 没有数值能同时满足约束 { $named }：均未施加
the-constraints-were-not-applied-the-readings = 约束未施加：读数未能确定全部参数，或求解未成功
constraint-costs-in-chi-square = 约束 { $index }（{ $text }）使 χ² 增加 { $cost }
rejected-the-readings-contradict-the-bounds-p = 拒绝：读数与界限相矛盾（p = { $p }）
no-bound-is-active-the-estimate-is = 没有起作用的界限：估计值即无约束估计值

# report/monte_carlo.rs
the-first-order-does-not-describe-its = 一阶近似不足以描述 { $id }：其 { $level } % 区间端点相差达 { $sd } u；请采用蒙特卡洛法的区间

# fit/remarks.rs
all-values-of-lie-within-degrees-and = { $name } 的全部数值都在 6.3 度以内，若为弧度则恰绕一周：这些数值是否为弧度？
condition-the-readings-hardly-tell-some-parameters = 条件数 { $condition }：读数几乎不能区分某些参数；请检查输入量的单位和相关系数

# fit/gauss_newton.rs
stop-settled = 最后一步已无影响
stop-unsettled = 最后一步内的尺度未能稳定
stop-limit = 步数已达上限
stop-stalled = 步长仍大而拟合不再改善：读数几乎不能确定某个方向
stop-no-descent = 最后一步的任何部分都不能改善拟合
stop-out-of-range = 数值超出双精度范围

# campaign/identity.rs
identity-unit = 被测件
identity-serial = 编号 { $serial }
identity-date = 日期
identity-place = 地点
identity-operator = 操作者
identity-instrument = 测量设备
identity-certificate = 证书
identity-valid-to = 有效期至
identity-traceable-to = 溯源至
identity-procedure = 测试程序
identity-environment = 环境条件
identity-note = 备注

# 多处使用
correction-error-in = { $id } 为 { $error } { $unit }
robust-estimate-settled = 稳健估计（{ $method }）经 { $steps } 步收敛
robust-estimate-did-not-settle = 稳健估计（{ $method }）经 { $steps } 步仍未收敛
no-loud = 否
joined-by-and = { " 和 " }
state-and-meaning = { $state }{ $between }。{ $meaning }
from-to = { $a } 至 { $b }
colon-why = ：{ $why }
conformity-passes = 合格。判定规则：{ $rule }。
conformity-fails = 不合格。判定规则：{ $rule }。
conformity-is-undecided = 不能判定。判定规则：{ $rule }。
simple-acceptance-the-estimate-inside-the-limits = 简单接受：估计值在限内即合格（JCGM 106, 8.2）
guard-band-w-u-pass-inside-by = 保护带 w = U({ $percent } %)：在限内且距限不小于 U 为合格，在限外且距限不小于 U 为不合格（JCGM 106, 8.3）
specific-risk-pass-where-conformity-is-at = 特定风险：合格概率不小于 { $percent } % 为合格，不合格概率不小于该值为不合格（JCGM 106, 7）
tone-plain = 说明
tone-good = 正常
tone-caution = 注意
tone-bad = 拒绝

# 证书
angles-and-coefficients = 角度与系数
dcc-model = 模型：{ $models }。
dcc-least-squares = 最小二乘法（{ $estimator }），{ $readings } 个读数，自由度 { $dof }。
dcc-known = 已知量：{ $known }。
dcc-assumed-zero = 设为零：{ $assumed_zero }。
dcc-not-estimable = 不可估计，因而未给出：{ $text }。
dcc-robust = 稳健估计：{ $method }。
dcc-global-test-failed = 整体 χ² 检验未通过，p = { $p }。
dcc-global-test-passed = 整体 χ² 检验通过，p = { $p }。
dcc-what-scatters = 不确定度中已计入的各偏差的标准差。
dcc-estimated-values = 由读数估计（{ $levels } 个水平）
dcc-stated-values = 给定（{ $levels } 个水平）
dcc-standard-uncertainty = 标准不确定度 { $u }
dcc-covariance = 估计值的协方差
dcc-jointly = 全部估计值联合

# report/changes.rs, report/html/changes_page.rs
before = 前次
after = 本次
difference = 差值
per-day = 每日变化
changed = 有变化
two-calibrations = tumble { $tumble }：同一被测件的两次标定
calibrated-before = 前次：{ $who }
calibrated-after = 本次：{ $who }
u-expanded-uncertainty-of-the-difference-e = U：差值的扩展不确定度（{ $level } %）；E_n = 差值/U；“有变化”：各量一并检验时显著（Holm 法）
the-unit-has-changed = 被测件已发生变化
no-change-beyond-the-uncertainties = 没有超出不确定度的变化
f-with-and-degrees-of-freedom = F = { $f }，自由度 { $dof } 和 { $scatter_dof }
chi-square-with-degrees-of-freedom = χ² = { $statistic }，自由度 { $dof }
all-parameters-together-p = 全部参数一并检验：{ $test }，p = { $p }：{ $verdict }
shared-inputs-none-both-count-as-independent = 共用输入量：无；两次标定按相互独立处理
shared-inputs-not-counted-twice = 共用输入量（不重复计入）：{ $shared }
combined-estimate-u-holds-only-where-both = 合并估计值；仅当两次标定一致、即 Birge 比不明显大于 1 时，u 才成立
birge-ratio = Birge 比
changes-only = 仅{ $which }有：{ $ids }
tumble-history-of-calibrations = tumble { $tumble }：{ $calibrations } 次标定的历史
date = 日期
serial = 编号
file = 文件
leaves-its-limits-about = 约于 { $day } 超限
drifts = 有漂移
too-few-dates = 日期太少
first = 首次
last = 末次
per-year = 每年变化
two-calibrations-of-one-unit = 同一被测件的两次标定
what-changed-by-more-than-the-uncertainties = 哪些量的变化超出了不确定度
title-before = 前次
title-after = 本次
the-answer = 结论
the-unit-has-changed-all-parameters-together = 被测件已发生变化：全部参数一并检验有显著差异（p = { $p }），但没有单个参数的变化是确定无疑的。
no-quantity-changed-by-more-than-the = 没有量的变化超出两次标定的不确定度。
changed-by-more-than-the-uncertainties-allow = 变化超出不确定度的量：{ $ids }。
no-input-is-shared-both-calibrations-count = 没有共用的输入量：两次标定按相互独立处理。
shared-by-both-calibrations-and-therefore-not = 两次标定共用、因而不重复计入的输入量：{ $shared }。
u-expanded-uncertainty-of-the-difference-e-2 = U：差值的扩展不确定度；E_n = 差值/U。带标记者：各量一并检验时显著（Holm 法）。
difference-over-u-bars-u = 差值与 U 之比（误差棒：U）
differences-of-the-two-calibrations-over-their = 两次标定的差值与其扩展不确定度之比
each-difference-over-its-expanded-uncertainty-a = 各差值与其扩展不确定度之比：误差棒不含零即为有变化。
the-weighted-mean-of-both-its-u = 两次标定的加权平均；仅当两次标定一致、即 Birge 比不明显大于 1 时，其 u 才成立。
combined-estimate = 合并估计值
history-of-calibrations = { $calibrations } 次标定的历史
each-quantity-over-time-with-its-trend = 各量随时间的变化、趋势与限值
no-quantity-drifts-by-more-than-its = 没有量的漂移超出其各次标定的分散。
drift-beyond-the-scatter-of-the-calibrations = 漂移超出各次标定分散的量：{ $drifts }。
leaves-its-limits-about-2 = `{ $id }` 约于 { $day } 超限。
over-time = { $id } 随时间的变化
with-bars-of-u-dashed-limits-line = `{ $id }`，误差棒为 2 u；虚线：限值；实线：显著时的趋势。
over-time-2 = 随时间的变化
year = 年

# compare/misprints.rs
the-tables-own-readings-give-another-value = 由表中读数得出的是另一个值
printed-with-the-opposite-sign-to-the = 印刷的符号与表和公式相反
printed-with-the-opposite-sign-to-the-2 = 印刷的符号与表和公式相反，且末位有差
this-is-the-value-of-group-not = 这是第 { $value } 组的值，不是均值
not-the-mean-of-the-table = 不是表中数据的均值
mean-of = { $id } 的均值
in-the-printed-equation = 印刷公式中的 { $id }
the-printed-equation-has-the-printed-chain = 印刷公式中有 { $id }，印刷的旋转链中却没有
coefficient-of-in-the-printed-equation = 印刷公式中 { $id } 的系数
the-chain-of-rotations-gives-the-opposite = 由旋转链得出的符号相反
the-chain-of-rotations-gives-another-value = 由旋转链得出的是另一个值
misprint-of = { $what }：
quantity-at = { $value } 处的 { $id }

# fit/azimuth.rs
azimuth-is-any = 两个分量都可能为零，任何方向均有可能：区间为整个圆周，u 取方位完全未知时的标准不确定度
azimuth-interval = { $level } % 区间为 { $low } 至 { $high }{ $unit }：分量接近零，该区间不同于量值 - U 至量值 + U

# correction
left-out-not-estimable = 不可估计：{ $names }
its-line-does-not-bind = 其模型不能代入数值
its-line-has-no-slope-at-zero-input = 其模型在零输入处没有斜率
its-line-follows-no-rate = 其模型的一阶项不含角速率和比力
dcc-as-found = 调整前（原始状态）
dcc-as-left = 调整后（交付状态）
dcc-state-of-item = 被测件状态
dcc-title-and-state = { $title }：{ $state }
dcc-probability = 合格概率 { $probability }。
dcc-correction = 一阶修正：输入量 = 矩阵 ×（读数 - 零偏），坐标系 { $frame }。
dcc-row = { $input } 对应的矩阵行
angles-at-bounds = 竖线：起作用的界限；此处误差棒为区间中界限所容许的部分。
source-weights = 权的估计（Kenward-Roger）
