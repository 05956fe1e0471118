# 报告用语(简体中文)。术语依据:JJF 1059.1、JJF 1001、GJB 2426A、GJB 1037A。参数在进入语句之前已经格式化。

## 标点

mark-comma = { "、" }
mark-clause = { "，" }
mark-semicolon = { "；" }
mark-colon = { "：" }
mark-stop = { "。" }
mark-space = { "" }
in-parentheses = （{ $text }）
has-capitals = no

## 列举与计数

list-and = { $before } 和 { $last }
count-reading = { $n } 个读数
count-prior = { $n } 个先验值
count-iteration = { $n } 次迭代
count-parameter = { $n } 个参数
count-degree = 自由度 { $n }

## 报告的固定词汇

term = { $word ->
    [free] 自由
    [at-bound] 位于界限上
    [fixed] 由等式确定
    [not-estimable] 不可估计
    [pass] 合格
    [fail] 不合格
    [undecided] 不能判定
    [exact] 精确
    [linear] 线性
    [normal] 正态
    [rectangular] 均匀
    [triangular] 三角
    [arcsine] 反正弦
    [given] 命令行给定
    [stated] 给定
    [estimated] 估计
    [residuals] 由残差估计
    [replicates] 由重复读数估计
    [fitted] 拟合值
    [start] 初值
    [prior] 先验值
    [equality] 等式
    [inactive] 不起作用
    [active] 起作用
    [at-limit] 起作用
    [contradictory] 相互矛盾
    [wrong] 与读数相矛盾
    [not-applied] 未施加
    [left-out] 未施加
    [lower] 下限
    [upper] 上限
    [norm] 范数
    [accepted] 接受
    [rejected] 拒绝
    [malformed] 数据不合要求
    [effects-found] 发现误差项
    [partly-explained] 部分得到解释
    [nothing-missing] 无缺项
    [unexplained] 无法解释
    [not-diagnosable] 无法诊断
    [stuck-channel] 通道卡死
    [global-test] 整体检验未通过
    [no-convergence] 不收敛
    [constraints] 约束
    [lack-of-fit] 失拟
    [suspicious-readings] 可疑读数
    [repeated-rows] 重复的行
    [outside-limits] 超出限值
    [goal] 达到目标
    [absent] 缺失
    [saturation] 饱和
    [spike] 尖峰
    [stuck] 卡滞
    [turned-180] 关节转了 180 度
    [another-position] 方案中的另一位置
    [wrong-sense] 转动方向相反
    [exchanged-axes] 关节互换
    [exchanged-sensors] 传感器互换
    [slipped-mounting] 安装松动
    [bad-reading] 坏值
    [missing-effect] 模型缺少的误差项
   *[other] { $word }
}

# report/fit_table.rs
derived = 间接量
parameter = 参数
estimate = 估计值
dof = 自由度
unit = 单位
state = 状态
record-of-rows-read = 记录共 { $rows } 行；读数表和图中为其中 { $shown } 行。
rows-in-a-mean = 均值的行数
sd-over-that-of-independent-rows = 标准差与独立行之比
row-of-the-record = 行
that-of-rounding-to-its-last-digit = { $beyond ->
    [yes] 取自修约到 { $step }（末位，除以 √12）：除各分散项外，读数的方差估计为零
   *[no] 取自修约到 { $step }（末位，除以 √12）：读数的分散不超过此值
}
the-rounding-of-its-readings-which-show = { $beyond ->
    [yes] 取自读数的修约，除各分散项外读数未表现出分散
   *[no] 取自读数的修约，读数未表现出分散
}
residual-sd-of = { $per_sample ->
    [yes] `{ $sensor }` 单个样本的残差标准差
   *[no] `{ $sensor }` 的残差标准差
}：{ $sd }。
inconsistent-disagrees-with-the-other-sights-by = `{ $sensor }` 不一致：与其余瞄准读数平均相差 { $mean_residual_deg } deg。请检查是否瞄准了目标的另一面、瞄错了点或初值相差太远。
correlated-inputs = 相关的已知量：{ $list }
no-reading-responds-to-at-the-reference = 在参考点处没有读数对 { $moved } 有响应（与其相乘的量全为零）：拟合从参考点旁边开始。
held-where-the-iteration-began-since-the = 保持迭代初值，因为精确模型在其以外对下列参数的约束太弱：{ $held }。
gauss-newton-converged-after = { $differs ->
    [yes] 高斯-牛顿法经 { $steps }收敛。线性估计值（从参考点出发的一步）与之相差超过 0.1 u（精确减线性）：{ $what }。
   *[no] 高斯-牛顿法经 { $steps }收敛；线性估计值（从参考点出发的一步）与之相差不超过 0.1 u。
}
u-holds-only-for-as-held-another = U 仅在 `{ $held }` 保持现值时成立：将其改变 { $by }，则 { $shifts } 随之改变。
derived-without-a-value = 以下间接量没有结果（依赖不可估计的参数，或在解处不是数）：{ $names }
no-reading-responds = { $here ->
    [yes] 在该点没有读数对其有响应
   *[no] 没有读数对其有响应
}
a-reading-would-separate = { $what ->
    [position] 在 { $keys } 处增加一个读数即可将其分离
    [sensor] 增加 { $sensor } 的一个读数即可将其分离
   *[both] 在 { $keys } 处增加 { $sensor } 的一个读数即可将其分离
}
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
correlation = 相关系数
is-at-a-bound-interval-to-of = `{ $id }` 位于界限上：{ $level } 区间为 { $low } 至 { $high } { $unit }（无约束估计的区间，截取容许部分）。
is-at-a-bound-and-the-whole = `{ $id }` 位于界限上，而无约束估计的 { $level } 区间全部在容许范围之外：界限与读数不相容。
monte-carlo = 蒙特卡洛法
mean = 均值
coverage-ellipsoid-of-k-p = { $order } 的包含椭球：k_p = { $k }
scale-factor-errors-are-not-drawn = 未抽样：{ $errors }

# report/correction.rs
the-lines-are-linear-in-the-inputs = 模型对输入量是线性的：此修正是精确的。
within-the-range-of-the-calibration-it = 在标定范围（{ $within }）内，剩余误差至多 { $errors }
below-the-standard-uncertainty-of-the-calibration = ，在该范围内处处小于标定的标准不确定度。
none = 无
within-of-that-range-it-stays-below = ；在该范围的 { $part } 以内小于标定的标准不确定度。超出时请用精确模型：`tumble apply` 即按精确模型修正。
correction-otherwise = { $id }（否则取 { $otherwise }）
correction-is-for = 零偏与矩阵对应于 { $at }；取其他值时由传感器模型给出。
these-sensors-do-not-determine-give-it = 这些传感器不能确定 { $given }：请在读数旁以一列给出。
correction-none-of-the-sensors-follows-a = 修正：没有传感器响应本拟合所能确定的角速率 w_* 或比力 a_*
input = 输入量
bias = 零偏

# report/html/fit_page.rs
made-by = 生成程序
sha-of = { $name } 的 SHA-256
bench = 测试装置
source = 来源
model = 模型
estimator = 估计方法
residuals-and-correlations = 残差与相关系数

# report/html/fit_answer.rs
result = 结论
global-test-chi-square-with-p = 整体检验：{ $rejected ->
    [yes] 读数的分散程度超出所给不确定度，模型有遗漏或不确定度给得过小
    [less] 读数的分散程度小于所给不确定度：不确定度给得过大，或读数并不独立
   *[no] 读数的分散程度与所给不确定度相符
}（χ² = { $chi_square }，{ $dof }，p = { $p }）。
the-readings-state-no-uncertainty-of-their = 读数未给出自身的不确定度：其分散由残差估计，因此仅凭这些读数不能检验模型。
no-degrees-of-freedom-the-readings-just = 自由度为零：读数恰好确定参数，无从检核。
one-linear-step-is-not-enough-gauss = 一步线性解不够：高斯-牛顿法还会使下列参数改变 0.1 u 以上：{ $what }。请去掉 `--linear` 再拟合。
from-the-fit-estimates-rank-of-freedom = 由 { $from }估计 { $parameters }（秩 { $rank }，{ $dof }）。
the-scaled-design-matrix-has-condition-number = 标度后的设计矩阵条件数为 { $condition }。

# report/html/fit_correction.rs
the-correction-to-apply = 修正公式
readings-cannot-be-corrected-not-estimable-here = 不能修正读数：{ $missing } 在此不可估计。
all-sensors-are-solved-together-for-the = 由全部传感器联立求解其所能确定的输入量。一阶修正为：
is-left-out-of-the-correction = 修正未包含 `{ $sensor }`：{ $why }。
the-rotation-from-the-sensors-axes-to = 从传感器轴到安装面的旋转需要 { $tilts }；其中 { $missing } 在此不可估计。
direction-cosines-of-the-corrected-inputs-on = 修正后输入量在安装面坐标系中的方向余弦
a-corrected-input-points-along-the-sensors = 修正后的输入量沿传感器自身的轴。相对于安装面（最后一个转轴之后的坐标系），这些轴转过了 { $tilts }；在安装面上已知的角速率或比力沿各轴的分量由下表给出：
belongs-to-the-bench-and-stays-there = { $others } 属于测试装置，不随被测件带走。

# report/html/fit_estimates.rs
angle = 角度
coefficient = 系数
u-combined-standard-uncertainty-k-u-expanded = u：合成标准不确定度；{ $expanded } = k u：扩展不确定度，包含因子 k 由 t 分布按有效自由度 ν 得出。
estimates = 估计结果
not-estimable-from-these-readings = 由这些读数不可估计
the-parameters-can-move-along-and-no = 参数可沿 `{ $text }` 变动而读数不变；{ $instead }。
determined-instead = 可确定的量
where-the-uncertainty-comes-from = 不确定度来源
u-of-source = 来源的 u
angles-in-radians-c-sensitivity-coefficient-of = 贡献以估计值的单位计（角度为角秒），来源以其自身单位计（角度为弧度）。c：单一来源的灵敏系数；ν：自由度；占比：在方差中所占的份额。
below-of-the-variance-left-out = 未列出的分量（小于方差的 0.05 %）：{ $hidden } 个。

# report/html/fit_figures.rs
angles-with-their-expanded-uncertainties = 各角度及其扩展不确定度（{ $level }）。
standard-uncertainties-divided-by-each-sources-share = 标准不确定度，按各来源在方差中的占比划分。
standard-uncertainty = 标准不确定度
coefficients-each-sources-share-of-the-variance = 系数：各来源在方差中的占比。低于 0.5 % 的来源留白。
residuals-of-figure = { $shared ->
    [yes] { $id } 的残差（已扣除各读数共有的偏差）与两倍标准差带。超出 { $limit } 倍标准差的读数（菱形）：{ $far }。
   *[no] { $id } 的残差与两倍标准差带。超出 { $limit } 倍标准差的读数（菱形）：{ $far }。
}
normal-plot-of-the-studentized-residuals-with = 学生化残差的正态概率图及逐点 95 % 带：残差服从正态分布时各点沿直线分布。
correlations-of-the-estimates-in-hundredths-blue = 估计值的相关系数（以百分之一计）：蓝色为正，橙色为负，叉号表示不可估计。

# report/html/fit_readings.rs
taken-as-zero-neither-known-nor-estimated = 取为零，既非已知也未估计：{ $assumed_zero }。
site-latitude-earth-rate-deg-h = 测试地点：纬度 { $latitude_deg }°，地球自转角速率 { $earth_rate_deg_h } deg/h，{ $said }。
no-site-no-earth-rate-and-gravity = 未给测试地点：不计地球自转角速率，重力取 9.80665 m/s^2（1 g）。
rows-are-exact-derivatives = { $iterated ->
    [yes] 精确：各行取精确导数，迭代至解。
   *[no] 线性：各行取参考点处的精确导数，由此走一步。
}
errors-are-independent = 除所列的分散性来源外，同一传感器各读数的误差相互独立、标准差相等，由残差估计。
known = 已知量
exact = 精确
what-was-assumed = 假设条件
redundancy-the-share-of-a-fault-that = 冗余数：粗差反映到该读数自身残差中的份额。最小可探测偏差：显著性水平 0.1 %、检验功效 80 % 时所能发现的最小粗差。带标记者：学生化残差超出 { $limit }。
the-first-of-are-listed-the-json = 共 { $n } 个，列出前 { $listed } 个。
readings = 读数

# report/html/checks_page.rs
the-robust-estimator-did-not-settle = 稳健估计（{ $method }）未收敛。
checks = 检验
test = 检验
statistic = 统计量
lack-of-fit = 失拟检验
lack-of-fit-by-position = 按位置的失拟检验
runs-of = `{ $sensor }` 的游程检验
runs-in-the-order-of = 按 `{ $column }` 顺序的 `{ $sensor }` 游程检验
runs-expected = 游程 { $runs } 个，期望 { $expected } 个
normality = 正态性
shift = 偏移
shift-how-far-the-reading-is-off = 偏移：该读数偏离其余读数所示值的量。p：对全部 { $tested } 个读数而言（Sidak）。
change-without-suspects = 剔除可疑读数后的变化
external-reliability = 外部可靠性
effect-what-the-smallest-detectable-fault-of = 偏移：影响最大的读数中的最小可探测粗差若未被发现，使参数改变的量。
constraints-and-weights = 约束与权
constraint = 约束
side = 侧
cost-in-chi-square = χ² 的增量
less-than-half-of-their-weight-readings = 权降到一半以下的读数：{ $low }。
checks-page-interval = 包含区间（{ $level }）
shortest = 最短区间
first-order = 一阶近似
of-trials-seed = { $asked } 次试验中 { $trials } 次有效，随机种子 { $seed }。
marked-the-first-order-is-not-good = { $trials }带标记者：一阶近似达不到不确定度的两位有效数字。

# report/html/conformity_page.rs
conformity = 合格评定
lower-limit = 下限
upper-limit = 上限
probability = 概率
probability-that-the-quantity-is-inside-its = 概率：以估计值为中心按 t 分布计算的、量值在限内的概率（JCGM 106, 7.3）。

# report/html/scatter_page.rs
what-scatters = 分散性来源
sd-standard-deviation-of-one-deviation-a = sd：单次偏差的标准差，由测试文件给定，或由本组读数估计（限制最大似然法）。不确定度中已计入各来源。

# report/plot/normal.rs
normal-quantile = 正态分位数
studentized-residual = 学生化残差

# report/plot/values.rs
estimate-and-expanded-uncertainty = 估计值与扩展不确定度

# report/plot/bars.rs
bars-type = { $name }（{ $type_b } 类）

# report/html/compare_page.rs
comparison-with-the-published-closed-forms = 与已发表闭式公式的比较
group-by-group-without-earth-rate = { $square ->
    [yes] 逐组比较且不计地球自转角速率（公式将其忽略）时，两者相差不超过量值的 { $difference }：公式是最小二乘的恰定特例。
   *[no] 逐组比较且不计地球自转角速率（公式将其忽略）时，两者相差达量值的 { $difference }：这些位置不是公式的恰定情形。
}
printed = 原文值
closed-form = 闭式公式
least-squares-no-earth-rate = 最小二乘（不计地球自转）
least-squares = 最小二乘
all = 全部
group-by-group = 逐组结果
computed = 计算值
probable-cause = 可能的原因
misprints-found = 发现的排印错误

# report/compare_table.rs
closed-form-and-least-squares-differ-by = 闭式公式与最小二乘相差至多为量值的 { $difference }。

# report/site.rs
altitude-of = 高程 { $altitude } m
site-gravity = 重力加速度：{ $gravity } { $unit }{ $u }{ $from }
gravity-is-not-stated-and-taken-as = 未给出重力加速度，取 { $standard_gravity_m_s2 } m/s^2；当地重力加速度可相差达 3000 ppm，以 m/s^2 为单位的系数亦然：请给出 `site.gravity`，或 `site.latitude_deg` 与 `site.altitude_m`

# report/scatter.rs
scatter-largest-share = 最大占比
source-readings-of = { $sensor } 的读数
source-priors = 先验值
source-per = { $of }（按{ $per }）
source-over-per = { $of }（按{ $per }，随 { $over } 相关）
campaign = 测试
source-note-sentence = { $source }：{ $note }。
estimated-as-zero = { $below ->
    [yes] 没有它读数的分散也不过如此：估计为零；u 与自由度并不依赖其为零
   *[no] 没有它读数的分散也不过如此：估计为零
}
no-reading-feels-it-here = 此处没有读数受其影响
these-readings-cannot-tell-it-from-their = 这些读数不能将其与{ $named ->
    [yes] { $others }
   *[no] 其余分散性来源
}分开：按两者之和处理；在同一水平上重复读数即可分开
the-unknowns-take-up-its-deviations = 待估参数吸收了其全部 { $count } 个偏差，无从得知其大小，因而无法给出 { $names } 的 u：{ $levels }
more-levels = { $per ->
    [reading] 至少还需在相同输入下再取 { $more } 个读数
    [position] 至少还需重新安装 { $more } 次（重复测量某一位置）
    [campaign] 至少还需 { $more } 次测试的读数，并以一列标明测试编号
   *[other] 至少还需 { $per } 另取 { $more } 个值时的读数
}
no-degrees-of-freedom-are-left-to = 没有剩余自由度用以估计
in-each-reading-as-stated = 各读数分别给定

# report/separation.rs
beyond-this-point-readings-respond-to-it = 离开该点读数才对其有响应，响应经由此处为零或与零难以区分的量：请给出一个值、先验值或初值
no-position-of-this-bench-would-separate-2 = 本测试装置的任何位置都不能将其分离
hides-in-and = { $last } 隐含在 { $join } 和 { $before } 之中

# report/fit_checks.rs
lack-of-fit-by-replicates = { $rejected ->
    [yes] 失拟：模型的剩余大于重复读数的分散（{ $test }，p = { $p }）
   *[no] 重复读数的分散与模型的剩余相当（{ $test }，p = { $p }）
}
lack-of-fit-between-positions = { $rejected ->
    [yes] 按位置失拟：模型在各位置之间的剩余大于同一位置读数的分散（{ $test }，p = { $p }）
   *[no] 模型在各位置之间的剩余与同一位置读数的分散相当（{ $test }，p = { $p }）
}
less-than-the-scatter = { $by_position ->
    [yes] 各位置之间的残差小于同一位置读数的分散所允许的程度
   *[no] 残差小于重复读数的分散所允许的程度
}（{ $test }，F 更小的概率为 { $p }）：该分散不只是噪声，其中含有在{ $by_position ->
    [yes] 位置平均值中不出现的影响，例如与角速率成比例的影响或漂移
   *[no] 重复读数平均值中不出现的影响，例如漂移或模型未使用的输入
}
diagnose-says-what-is-missing = 对本次试验运行 `tumble diagnose` 可查明模型缺少什么
residuals-of-have-too-runs-of-one = { $sensor } 残差的同号游程过{ $few ->
    [yes] 少
   *[no] 多
}（{ $runs } 个，期望 { $expected } 个，p = { $p }）：存在漂移或交替变化
prior-contradicts-the-readings = { $id } 的先验值与读数矛盾：二者相差 { $w } 倍标准不确定度（p = { $p }）
residuals-follow-a-column = { $sensor } 的残差随 { $column } 变化：按其顺序，同号游程过少（{ $runs } 个，期望 { $expected } 个，p = { $p }）
residuals-are-not-normal-shapiro-francia-w = 残差不服从正态分布（Shapiro-Francia W' = { $w }，p = { $p }）
lack-of-fit-over-an-input = 失拟：把 { $input } 的范围八等分，各段的阶跃对 { $sensor } 的解释超过噪声（χ² = { $chi_square }，自由度 { $dof }，p = { $p }）
lack-of-fit-or-correlation = { $sensor } 在 { $inputs } 上的失拟与该相关无法区分：请先说明噪声的时间相关
means-of-rows-scatter = { $much ->
    [yes] { $sensor } 的残差不独立：{ $rows } 行均值的分散为独立行的 { $ratio } 倍（p = { $p }），u 约偏小同样倍数；请在 "scatter" 中说明噪声的时间相关（"over" 时间列）
   *[no] { $sensor } 的残差中，{ $rows } 行均值的分散为独立行的 { $ratio } 倍（p = { $p }）：相邻残差相互抵消，或所给不确定度过大
}
residuals-are-correlated = { $sensor } 的残差相关：相隔 { $rows } 行时为 { $correlation }（对全部间隔 p = { $p }）
row-is-far-from-the-model = 可疑：{ $sensor } 的第 { $row } 行偏离模型 { $residual }（w = { $w }，对全部行 p = { $p }）
suspicious-reading-of-is-off-what-the = 可疑：{ $sensor } 的第 { $index } 个读数偏离其余读数所示值 { $shift }（w = { $w }，对全部 { $tested } 个读数 p = { $p }）
more-suspicious-readings = 另有 { $more } 个可疑读数：见页面或 JSON 报告

# report/fit_constraints.rs
no-values-meet-constraints-together-none-was = 没有数值能同时满足约束 { $named }：均未施加
the-constraints-were-not-applied-the-readings = 约束未施加：读数未能确定全部参数，或求解未成功
constraint-costs-in-chi-square = 约束 { $index }（{ $text }）使 χ² 增加 { $cost }
rejected-the-readings-contradict-the-bounds-p = { $bounds ->
    [yes] 拒绝：读数与界限相矛盾
   *[no] 拒绝：读数与等式相矛盾
}（p = { $p }）
no-bound-is-active-the-estimate-is = { $equations ->
    [yes] 没有起作用的界限
   *[no] 没有起作用的界限：估计值即无约束估计值
}
equations-cost-in-chi-square = { $n } 个等式使 χ² 增加 { $cost }{ $tested ->
    [yes] （p = { $p }）
   *[no] { "" }
}

# report/monte_carlo.rs
the-first-order-does-not-describe-its = 一阶近似不足以描述 { $id }：其 { $level } % 区间端点相差达 { $sd } u；请采用蒙特卡洛法的区间
bounds-held-trials-back = 部分试样受界限约束：所抽取的是有约束的估计值，而 u 与一阶近似区间属于无界限的估计值；两者不作比较

# fit/remarks.rs
times-go-back = { $name } 有 { $count } 处倒退（首次在第 { $reading } 个读数，{ $time }），其余均依次递增：这些时间是否正确？
positions-without-a-reading = 有 { $count } 个读数没有任何传感器的值，已略去（第一个：{ $first }）
all-values-of-lie-within-degrees-and = { $name } 的全部数值都在 6.3 度以内，若为弧度则恰绕一周：这些数值是否为弧度？
rates-outside-those-of-the-table = { $name } = { $rate } deg/s：转台的速率范围为 { $least } 至 { $most } deg/s；该值是否以 rad/s 或其他单位给出？
rates-would-be-round-as-radians = { $name } 的全部数值都在 6.3 deg/s 以内，若以 rad/s 计则均为 5 deg/s 的整数倍：其单位是否为 rad/s？
tilt-is-no-small-rotation = 倾角 { $id } = { $tilt } deg 已不是小倾角：按已知的 { $factor }，{ $sensor } 的读数与可能的值相差几个数量级；其单位是 { $unit } 吗？{ $factor } 是否正确？
factor-is-thousands-off-its-start = { $id } 为其初值的 { $ratio } 倍，且读数主要由它决定：{ $sensor } 的读数单位是 { $unit } 吗？
every-reading-of-a-channel-is-the-same = 输入量在变化，而 { $sensor } 的每个读数均为 { $value }：该通道已卡死，或其分辨力不足以显示变化
readings-repeat-others = 第 { $again } 个读数与第 { $first } 个读数逐位相同，而同一状态下的其他读数并不相同：若为重复录入，则 u 偏小
every-row-stands-there-several-times = 每一行均以完全相同的数值出现 { $times } 次：若为重复录入，则 u 按该次数的平方根偏小
condition-the-readings-hardly-tell-some-parameters = 条件数 { $condition }：读数几乎不能区分某些参数；请检查输入量的单位和相关系数

# fit/gauss_newton.rs
stop-settled = 最后一步已无影响
stop-unsettled = 最后一步内的尺度未能稳定
stop-limit = 步数已达上限
stop-stalled = 步长仍大而拟合不再改善：读数几乎不能确定某个方向
stop-no-descent = 最后一步的任何部分都不能改善拟合
stop-less-likely = 由于分散随估计值而变，读数在解处的似然远小于参考点处；请给出初值
stop-out-of-range = 数值超出双精度范围

# campaign/identity.rs
identity-unit = 被测件
identity-place = 地点
identity-operator = 操作者
identity-instrument = 测量设备
identity-valid-to = 有效期至
identity-traceable-to = 溯源至
identity-procedure = 测试程序
identity-environment = 环境条件
instrument-no-longer-valid = { $name } 的校准有效期至 { $valid_to }，而测量日期为 { $date }
interval-sums-over-the-likelihood-of-the-variances = 读数几乎不能确定某些方差：区间按似然对读数所容许的全部方差和相关时间加权求得，而不只取最可能的值
scale-factor-errors-need-readings = 流式读取的记录不给出标度因数的非线性度、不对称度、迟滞和重复性：请先归约为读数（tumble reduce）
scale-factor-error-has-limits = { $id } 设有限值，但这些读数不能给出该量：需要绕该传感器输入轴的至少三个速率，且视所比较的对象而定，需要两个转向、两个趋近方向或多次运行的读数

# 多处使用
correction-error-in = { $id } 为 { $error } { $unit }
from-to = { $a } 至 { $b }
conformity-is = 合格评定：{ $outcome }（{ $rule }）。
simple-acceptance-the-estimate-inside-the-limits = 简单接受：估计值在限内即合格（JCGM 106, 8.2）
guard-band-w-u-pass-inside-by = 保护带 w = U({ $percent } %)：在限内且距限不小于 U 为合格，在限外且距限不小于 U 为不合格（JCGM 106, 8.3）
specific-risk-pass-where-conformity-is-at = 特定风险：合格概率不小于 { $percent } % 为合格，不合格概率不小于该值为不合格（JCGM 106, 7）
note = 说明
tone-good = 正常
tone-caution = 注意
tone-bad = 异常

# 证书
robust-estimator = 稳健估计：{ $method }。
dcc-covariance = 估计值的协方差
dcc-relates-only-to-the-items = 结果仅与被校准的物品有关。
dcc-traceable = 结果通过 { $by } 计量溯源至 { $to }。
calibration-certificate = 校准证书
dcc-method = 多位置试验的最小二乘平差
dcc-uncertainty = 扩展不确定度：标准不确定度乘以所给的包含因子
dcc-not-stated = 未说明

# report/changes.rs, report/html/changes_page.rs
before = 之前
after = 之后
difference = 差值
per-day = 每日变化
reports-are-of-two-units = 两份报告属于两个被测件（{ $first } 与 { $second }）：其差异并非同一被测件的变化
first-report-is-the-later-one = 第一份报告的日期较晚（{ $first }，第二份为 { $second }）：前次与后次可能颠倒
f-test = { $is_of ->
    [yes] { $sensor }：F
   *[no] F
} = { $f }，自由度 { $between_dof } 和 { $pure_error_dof }
chi-square-with-degrees-of-freedom = χ² = { $statistic }，自由度 { $dof }
all-parameters-together-p = { $changed ->
    [yes] 全部参数一并检验：{ $test }，p = { $p }：被测件已发生变化。
   *[no] 全部参数一并检验：{ $test }，p = { $p }：没有显著变化。
}
birge-ratio = Birge 比
changes-only = 仅{ $which }有：{ $ids }
date = 日期
serial = 出厂编号
last = 末次
per-year = 每年变化
two-calibrations-of-one-unit = 同一被测件的两次标定
changed-by-more-than-the-uncertainties-allow = 变化超出不确定度的量：{ $ids }。
beyond-u-but-not-together = 变化超出扩展不确定度（|E_n| > 1），但 { $tested } 个量一并检验时不显著：{ $ids }。
shared-by-both-calibrations-and-therefore-not = 两次标定共用、因而不重复计入的输入量：{ $shared }。
u-expanded-uncertainty-of-the-difference-e-2 = U：差值的扩展不确定度；E_n = 差值/U。带标记者：各量一并检验时显著（Holm 法）。
differences-of-the-two-calibrations-over-their = 两次标定的差值与其扩展不确定度之比：误差棒不含零即为有变化。
the-weighted-mean-of-both-its-u = 两次标定的加权平均；仅当两次标定一致、即 Birge 比不明显大于 1 时，其 u 才成立。
history-of-calibrations = { $calibrations } 次标定的历史
drift-beyond-the-scatter-of-the-calibrations = 漂移超出各次标定分散的量：{ $drifts }。
leaves-its-limits = { $past ->
    [yes] `{ $id }` 约于 { $day } 已超限。
   *[no] `{ $id }` 约于 { $day } 超限。
}
over-time = 随时间的变化
bars-limits-and-trend = 误差棒：2 u。虚线：限值。实线：显著时的趋势。
year = 年

# compare/misprints.rs
the-tables-own-readings-give-another-value = 由表中读数得出的是另一个值
printed-with-the-opposite-sign = { $off ->
    [yes] 印刷的符号与表和公式相反，且末位有差
   *[no] 印刷的符号与表和公式相反
}
this-is-the-value-of-group-not = 这是第 { $value } 组的值，不是均值
not-the-mean-of-the-table = 不是表中数据的均值
mean-of = { $id } 的均值
in-the-printed-equation = 印刷公式中的 { $id }
the-printed-equation-has-the-printed-chain = 印刷公式中有 { $id }，印刷的旋转链中却没有
coefficient-of-in-the-printed-equation = 印刷公式中 { $id } 的系数
the-chain-of-rotations-gives-the-opposite = 由旋转链得出的符号相反
the-chain-of-rotations-gives-another-value = 由旋转链得出的是另一个值
quantity-at = { $value } 处的 { $id }

# fit/azimuth.rs
azimuth-is-any = 两个分量都可能为零，任何方向均有可能：区间为整个圆周，u 取方位完全未知时的标准不确定度
azimuth-interval = { $bounded ->
    [yes] { $level } % 区间为 { $low } 至 { $high }{ $unit }：该区间与 U 属于无约束估计，截取界限所容许的部分
   *[no] { $level } % 区间为 { $low } 至 { $high }{ $unit }：分量接近零，该区间不同于量值 - U 至量值 + U
}

# fit/scale_factor.rs
largest-of-alike = { $of } 个偏差中的最大值，其中 { $alike } 个在噪声范围内与最大值无法区分：k 取 { $alike } 个之最大值的包含因子
scatter-of-runs = { $runs } 轮测试斜率的离散程度，包含读数噪声

# correction
left-out-not-estimable = 不可估计：{ $names }
its-line-does-not-bind = 其模型不能代入数值
its-line-has-no-slope-at-zero-input = 其模型在零输入处没有斜率
its-line-follows-no-rate = 其模型的一阶项不含角速率和比力（没有转动链的装置用 "in_use" 说明哪些列是角速率和比力）
its-norm-is-of-no-triad = 其模型是一个矢量的模，而该矢量不是相同个数读数的仿射函数，或其单位不是角速率或比力的单位
dcc-as-found = 调整前（原始状态）
dcc-as-left = 调整后（交付状态）
dcc-correction = 一阶修正：输入量 = 矩阵 ×（读数 - 零偏），坐标系 { $frame }。
dcc-row = { $input } 对应的矩阵行
angles-at-bounds = 竖线：起作用的界限；此处误差棒为区间中界限所容许的部分。
source-weights = 权的估计（Kenward-Roger）

# report/diagnose、batch、navigate_diagnose
effects-are-missing = { $n ->
    [1] 模型缺少一个误差项：{ $names }
   *[other] 模型缺少 { $n } 个误差项：{ $names }
}
what-remains-is-more-than-noise = { $found }；{ $more ->
    [yes] 余下部分仍大于噪声
   *[no] 余下部分不大于噪声，但有规律
}，再无可能的误差项
effects-are-suspected = { $more ->
    [yes] 残差大于噪声
   *[no] 残差不大于噪声，但有规律
}；有嫌疑但概率不足以命名、或在其不确定度内与零无差异的误差项：{ $suspected }
and-further-effects-are-suspected = { $found }；此外有嫌疑的误差项：{ $suspected }
effect-with-probability = { $name }，概率 { $p }
nothing-is-missing = { $noise ->
    [known] 模型不缺误差项：残差仅为噪声
    [scatter] 没有误差项的显著性超出偶然；分散程度由本组读数估计，因此这组读数只能说明到此
   *[residuals] 没有误差项的显著性超出偶然；噪声只能由残差得知，因此这组读数只能说明到此
}
nothing-is-probable = 残差大于噪声（p = { $p }），但没有误差项的概率足以列为可疑：无法判断模型是否缺误差项
unexplained = { $more ->
    [yes] 残差大于噪声
   *[no] 残差不大于噪声，但有规律
}，所试的误差项及其组合均非可能的解释
not-diagnosable = { $of ->
    [mission] 无法诊断：实测数据少于三个
   *[campaign] 无法诊断：读数刚好够确定各未知量，没有多余读数可供检验
}
effect-named = { $name }（`{ $regressor }`）
effect-in-sensors = { $name }（{ $sensors }）
effect-or-others = { $n ->
    [1] { $name }，或另外一个在本试验编排下与其无法区分的误差项
   *[other] { $name }，或另外 { $n } 个在本试验编排下与其无法区分的误差项之一
}
readings-were-averaged = ；{ $from } 个读数已按同一状态、同一时段平均为 { $groups } 个
candidates-tried = 试用候选项 { $candidates } 个，其中 { $distinct } 个在这些数据中互不相同，各 p 值均已计入这一点；显著性水平 { $significance }{ $averaged }
columns-not-tried = 列 { $columns } 未作为候选项试用，因为其标题不能作为模型算式中的名称；可在测量文件的 `columns` 中为标题指定名称
one-further-reading-would-help = 再增加一个读数即可诊断；最佳位置：{ $positions }
diagnosis-of = { $title }：诊断
explains-beyond-the-others = 解释程度：在其他各项之外，所占残差平方和的份额。
noise-from = { $from ->
    [stated] 按所给值
    [replicates] 由重复读数估计
   *[residuals] 取自最终模型的残差：别无其他依据，因此无法检验模型是否完备
}
error-of = { $id } 的误差
error-of-the-prior-of = { $id } 的先验值误差
it-misses-by = 不符值
against-its-stated-uncertainty = { $within ->
    [yes] 为其所给标准不确定度的 { $times } 倍：并非错误，只是读数对它的约束更强；宜以所给值作为先验值加以估计
   *[no] 为其所给标准不确定度的 { $times } 倍：所给值有误
}
is-now-estimated = { $was ->
    [known] { $id } 改为待估参数，不再作为已知量
    [prior] { $id } 不用先验值进行估计
   *[tilt] { $id } 改为待估参数，不再取零
}
constraint-is-taken-away = 去掉约束 { $number }
together-with = 与 { $other } 同时存在
discriminates = { $at }（可区分 { $n } 项，共 { $of } 项）
the-model-has-all-but = 除 { $share } 外均已含在模型中
of-its-full-size = 仅为其满量值的 { $share }
u-after-includes = { $what ->
    [both] 修正后的 u 计入了混淆项也可能是真实误差项这一情况（各混淆项使估计值移动的量不同，按各自概率计入），并计入了未能解释的部分；变化量与不含这两部分的 u 相比。
    [aliases] 修正后的 u 计入了混淆项也可能是真实误差项这一情况（各混淆项使估计值移动的量不同，按各自概率计入）；变化量与不含这一部分的 u 相比。
   *[remainder] 修正后的 u 计入了未能解释的部分；变化量与不含这一部分的 u 相比。
}
what-is-unexplained-follows = 未能解释的部分随{ $name }变化
what-is-unexplained-differs = 未能解释的部分逐个读数各不相同
with-a-standard-deviation-of = { $follows }，标准差为 { $sd } { $unit }
probability-of-it-or-an-alias = { $p }（该项或其混淆项存在），{ $named }（即为所命名的项）
fit-takes-the-effect-as-named = 对该测试文件的拟合按所命名的误差项进行（{ $named }）；若实际为其某一混淆项，估计值将随之移动，其中 { $id } 最大，为 { $by } { $unit }（按所命名的项 u = { $u }）；诊断报告的 u_after 已计入此项
constraint-state = 约束 { $index }，{ $text }：{ $state }
holdout = 逐一留出并由其余位置预测，{ $n } 个位置的预测误差为其标准不确定度的 { $before } 倍（方均根，期望为 1）{ $found ->
    [yes] ，计入所发现的误差项后为 { $after } 倍
   *[no] { "" }
}{ $skipped ->
    [0] { "" }
   *[other] ；{ $skipped } 个位置不能留出，因其单独确定某个参数
}
further-sensors-are-not-drawn = 另有 { $n } 个传感器未画出。
setting = 设置
rows-of = { $motion } { $n } 行
in-the-mission = 任务文件中
refits = 完整仿真运行了 { $times } 次，重新拟合仍未收敛。
the-gap-by-channel = 各通道的残差
navigation-errors = 导航误差
count-device = { $n } 个被测件
effect = 误差项
wrote = 已写出 { $file }
note-nothing-found = { $what ->
    [error] 注：未发现误差，因此不写出任务文件
   *[effect] 注：未发现误差项，因此不写出修正后的模型
}
and-more = { $shown } 以及另外 { $more } 项
chi-square = χ²
residual-sd = 残差标准差
max = 最大
noise-floor = 噪声水平：{ $noise }
as-given = 原有
nearest-of-the-catalogue-would-take-off = 目录中最接近的是 { $names }：可减少 { $share } %；其概率不足，或其值在不确定度内与零无异，因此不予采用。
shift-u = 偏移/u
what-is-missing = 缺少的误差项
unknown = 未知
noise-sd = 噪声标准差
explains = 解释程度
fits-not-significantly-worse = 拟合优度无显著差别的项
only-through-small-terms = 只能通过微小项起作用的项
no-position-of-this-bench-tells-it = 以 45 deg 为步长、按本试验编排的速率，任何位置都不能与之区分的项
to-confirm = 验证方法
with-what-was-found = 计入所发现的误差项
the-pattern = 残差的规律
mean-residual-at-each-state-of-the = 各转轴状态下残差的均值，最显著者在前；z：以标准差为单位。
marked-shifts-of-more-than-twice-their = 有标记的行：变化超过其标准不确定度的两倍。
what-it-does-to-the-estimates = 对估计值的影响
where-the-gap-is = 残差所在
means-of-the-residuals-with-the-model = 原模型残差的均值，各水平单独计算；z：以标准差为单位。
in-the-model = 模型中的项
strongest-further-candidate = 最强的其余候选项
p-of-what-is-left = 余下部分的 p
the-gap = 残差逐步减小的过程
taken-as-known = 作为已知量：{ $known }。
priors-entered-as-rows-of-their-own = 先验值作为单独的观测行：{ $priors }。
gauss-newton-does-not-converge-here-so = 高斯-牛顿法在此不收敛，因此按线性估计进行诊断。
each-reading-minus-the-model = { $found ->
    [yes] 残差：空心圆为原模型，实心圆为计入所发现的误差项。
   *[no] 原模型的残差。
}
readings-are-grouped-by-which-the-gap = 读数按残差所依从的主要因素（{ $factor }）分组；横线为修正前的组平均值。
one-reading-in-is-drawn = 每 { $every } 个读数画出一个，离群的读数全部画出。
readings-near-number = 第 { $number } 个读数附近
readings-in-their-order = 按顺序排列的读数
noise-standard-deviations = 噪声，±2 倍标准差
reasons = 原因
devices-tested = 已检验
expected-by-chance = 偶然预期
beyond-chance = 超出偶然
chance-alone-finds = 一个被测件可有多个原因。偶然预期：并无异常时该检验在 { $level } 水平上检出的被测件数。超出偶然：就全部被测件而言在 { $level } 水平上检出的被测件数。
observed-sd = 估计值的标准差
sd-of-devices = 被测件间标准差
verdict = 结论
limits = 限值
all-are-accepted = { $devices }全部接受。
of-are-not-accepted-rejected-a-rank = { $devices }中有 { $bad } 个未接受：{ $rejected } 个被拒绝（秩亏、整体检验未通过、失拟或不收敛），{ $malformed } 个的读数不符合本测试文件。
conformity-rule-pass-undecided-fail = 合格评定（判定规则 `{ $decision }`）：合格 { $pass }，不能判定 { $undecided }，不合格 { $fail }。
devices-differ-by-more-than-their-readings = 在被测件之间的差异超出其读数分散的量（p < 0.01）：{ $names }。
devices = 被测件
p-if-alike = 无差异时的 p
min = 最小
accepted-devices-only-sd-between-devices-u = 仅统计已接受的被测件；均值与标准差不含离群被测件。估计值的标准差：各被测件估计值的标准差；u：各被测件标准不确定度的方均根；被测件间标准差：其中不能由各自读数的分散解释的部分；无差异时的 p：若各被测件无差异，出现如此标准差的概率（F 检验，给定不确定度时为 χ² 检验）。
distributions = 分布
each-histogram-shows-the-accepted-devices-the = 各直方图为已接受的被测件；曲线为仅由各自读数的分散所致的分布，虚线为限值。远离的值计入首末两格。
devices-that-are-not-in-order = 异常被测件
devices-that-stand-apart = 离群的被测件
accepted-devices-are-noisy = { $n ->
    [1] 有一个接受的被测件，其残差的离散大于其余被测件：{ $names }。
   *[other] 有 { $n } 个接受的被测件，其残差的离散大于其余被测件：{ $names }。
}
sd-of-the-others = 其余被测件的标准差
noisy-devices-f = 残差离散大于其余被测件：F =（残差标准差 / 离散较小的各被测件的合并标准差）^2，p 仅就该被测件而言；列出的超出全部被测件上 1 % 的水平（Cochran 最大方差检验，ISO 5725-2），最大者在前，至多 50 个。请检查该被测件的读数、通道和电缆。
no-accepted-device-stands-apart-from-the = 就全部被测件和全部量而言，在 1 % 水平上没有离群的被测件。
z-value-median-mad-beyond-what-a = z = （量值 - 中位数）/（1.4826 MAD），列出的值超出正态分布在全部被测件和全部量上 1 % 的范围；最远者在前，至多 50 个。
control-charts = 控制图
lots-beyond-their-control-limits = 超出控制限的批次均值：{ $lots }。
points-are-means-of-lots-the-line = 各点为批次均值，实线为不含离群者的已接受被测件的均值，虚线为批次均值的三倍标准差（由批内分散求得）；三角形为超出者。
rows-of-other-scenarios-left-out = ；其他情形的 { $rows } 行未采用
motion = 运动
time = 时间
outliers = 离群值
these-data-cannot-show = 这些数据不能反映 { $sources }。
absurd = （不合理）
rms = 方均根
measured-navigation-errors = 实测
values-are-changes-of-the-missions-errors = 量值为任务文件中误差的改变量。
gap-in-standard-uncertainties = 残差（实测减预测），以标准不确定度计
channel = 通道
values = 数据个数
gap-of = `{ $name }`{ $where_ } 的残差：方均根 { $size }
what-is-left-of-with-two-standard = `{ $name }`{ $where_ } 的余下部分，以及两倍标准不确定度
discriminated-by = 用于区分的测量

# cli
error-what = 错误：{ $text }
error-expected = 应为：{ $text }
error-option = 选项：{ $text }
error-found = 实际为：{ $text }
error-in = 文件 { $file }
error-line = ，第 { $line } 行
error-column = ，第 { $column } 列
error-at = 位于 { $path }

# plan、foresight、navigate、reduce、noise
uncertainty-depends-on-a-value = { $untold } 的不确定度取决于 { $needs } 的值，而该值未给出：取零时其影响消失；请用 --at { $first }=值 或 "start" 给出
values-checked-by-no-other = 没有冗余的数据：{ $n }
bounds-not-counted = 有 { $n } 个界限未计入：界限只在起作用时才减小不确定度
is-not-estimable = { $text } 不可估计
u-at-equal-effort = { $cost ->
    [yes] 费用相同
   *[no] 读数相同
}
cannot-be-determined-by-any-choice = { $text } 用这些候选位置的任何组合都不能确定
to-run-in-this-order = 按下列顺序进行
fewer-readings-cannot-reach-it = ；更少的读数不能达到
shows-from = 可发现的最小值
and-shifts = 所致参数变化
plan-rank = 秩 { $rank }，{ $dof }
combinations-cannot-be-estimated = 不可估计的参数组合：{ $n } 个。
to-s = 止，s
tilt = 水平姿态误差
carried-by = 方法
none-at-the-equator = 无（位于赤道）
schuler-earth-foucault = 舒勒周期 { $schuler } min，地球自转周期 { $earth } h，傅科周期 { $foucault }
record-changes = 记录不只是噪声：在 { $at } s 处，{ $tau } s 的均值变化了 { $by } { $unit }，为此噪声的 { $in_sd } 倍标准差；请检查传感器是否静止，或在该处截断记录
their-sum-describes = { $well ->
    [yes] 各项之和能够描述实测偏差
   *[no] 各项之和不能描述实测偏差；u 与各上限已计入此差异
}
no-coefficients = { $why ->
    [constant] 无系数：所有采样值相同
    [short] 无系数：平均时间不足五个倍频程（需 80 个采样，缺失不超过十分之一）
   *[undescribed] 无系数：各项之和无法给出这样的偏差
}
described-from = 短于 { $from } s 的平均时间未采用：传感器的滤波、保持或量化的采样不属于这些项
samples-left-out = 按缺失处理的采样：{ $events }
random-walk-sampled = 速率随机游走按每个 { $interval } s 间隔末端的瞬时值（而非间隔内的平均值）处理：以更少的项即可描述实测偏差
samples-mean = { $stretches ->
    [1] { $samples } 个采样，均值 { $mean } { $unit }。
   *[other] { $samples } 个采样，分为 { $stretches } 段，均值 { $mean } { $unit }。
}
allan = 阿伦
edf = 等效自由度
hadamard = 哈达玛
modified = 修正阿伦
noise-of-a-record = 记录的噪声
sampling-rate = 采样率
overlapping-allan-deviation-of-samples-with-its = { $samples } 个采样的重叠阿伦偏差及其 { $level } % χ² 置信区间；曲线为所拟合的各系数。
allan-deviation = 阿伦偏差，{ $unit }
segments-begin-and-end-with-blocks-of = 各段的起止以 { $block } 个采样的数据块为单位。
column-of-set-values = { $column } 在各段内均不变化：其样本既不显示噪声也不显示分辨力，如同设定值。{ $assumed ->
    [yes] 分辨力假定为末位小数 { $step }，u 为按此修约的不确定度。
   *[no] 数字未显示分辨力，u 为零。
}
noisier-segments = { $column } 在 { $count } 段中的散布大于其他段（第 { $segment } 段为其他段的 { $times } 倍）：这些段的 u 取自其自身及与其相似各段的噪声。
from-s = 起，s
reason = 原因
white = 白噪声
autocorr = 自相关
n-eff = 有效 n
lag = 滞后 1
slope-p = 斜率 p
from-samples-to-readings = 由采样求读数
samples = 采样
segments = 分段
not-used-of-means-have-a-slope = 采用 { $segments } 段，未采用 { $stretches } 段。存在噪声不能解释的斜率（p < 0.01）的均值：{ $sloping }（共 { $all } 个）。各段内计入均值的异常采样：{ $odd }。
the-whole-record-segments-are-shaded = 全部记录；阴影为各段。
record = 记录
u-on-either-side-of-a-mean = 噪声快于段长时，均值两侧各 1.96 `u` 包含 95 %；比段更慢的噪声不计入 `u`。`u` 由同一列中噪声相同的各段共同求得，并已计入由此带来的代价；其旁列出按白噪声、按自相关之和、按段长处阿伦偏差分别求得的值。
column = 列
odd = 异常采样
not-used-2 = 未采用
h-in-steps-of-s = { $duration } h，步长 { $step } s
duration = 时长
vertical-channel = 垂直通道
scenario = 情形
perfect-unit-a-perfect-unit-the-navigators = `perfect_unit`：理想惯性装置，即导航解算自身的误差。
azimuth = 方位
velocity = 速度
what-the-calibrations-uncertainty-does = 标定不确定度的影响
linear-covariance = 线性协方差
monte-carlo-draws = 蒙特卡洛法，{ $draws } 次
convention = 约定
periods = 周期
root-mean-square-errors = 方均根误差
against-the-first-motion = 与第一种运动相比
at-most-at-the-end = { $label }：最大 { $most }，终点 { $last }
curve-of = { $of } 的误差：{ $what }
after-h-the-position-is-off-by = { $motion }：{ $time } h 后位置误差 { $position } m（方均根 { $position_rms } m），方位误差 { $azimuth } arcsec（方均根 { $azimuth_rms }）
with-most-of-it-from-position-rms = { $text }，情形为 `{ $scenario }`；主要来自 { $sources }（位置，方均根）
position-at-the-end-m = 终点位置（m）
ratios-of-root-mean-squares-where-the = 方均根之比；- 表示第一种运动中该误差不超出导航解算自身的误差。
every-remounting-scatters-sd-rad-for-a = 每次重新安装时 { $id } 分散：标准差 { $sd }（角度以 rad 计）
zero-no-parameter-has-a-start-prior = 零（没有参数给出初值、先验值或 --at）
plan-table-others = 其余 { $count } 个 = 0
in-with-cost = { $readings }；安装 { $mountings } 次，变速 { $rate_changes } 次，费用 { $cost }
needs-a-value = 需给出值
largest-near-the-reference = 参考点附近的最大值
strongest-correlation = 最强相关
undetected-fault = 未发现粗差的影响
so-many-values-what-a-diagnosis-could = 读数过多：不预测诊断所能发现的误差项，也不逐个列出读数
uncertainty-through-tilts = { $counted ->
    [yes] 上表已计入：失准角为 { $tilts } arcsec 时，{ $known } 的不确定度给 { $parameter } 带来 { $u }{ $unit }
   *[no] 未计入：{ $known } 的不确定度通过失准角起作用，其大小不能由试验编排得知；失准角为 { $tilts } arcsec 时将给 { $parameter } 带来 { $u }{ $unit }（用 --tilts { $tilts } 计入）
}
best-of-all-choices = 这些候选位置的全部 { $all } 种容许组合中的最优者（已证明 100 %）
proven-efficiency = 已证明至少达到这些候选位置最优容许组合的 { $share }
the-bound-allows-more-mountings-than-the = 理论界允许的安装次数多于费用所允许的，因此该选择很可能就是最优
so-few-portions-cannot-follow-the-best = 份数太少，不能贴近最优权重；增加份数或减小每份可更接近
the-bound-itself-may-be-too-high = 理论界本身可能偏高 { $gap }
no-angle-is-worth-moving = 没有角度值得移离候选位置（最小步距 { $resolution }°）
angles-moved = { $finished ->
    [yes] 角度移离候选位置的安装（最小步距 { $resolution }°）：{ $mountings } 次；试验编排改善 { $gain } %
   *[no] 角度移离候选位置的安装（最小步距 { $resolution }°，搜索达到限度而停止）：{ $mountings } 次；试验编排改善 { $gain } %
}
cost-limit-of-the-search = { $budget ->
    [yes] 所选部分的费用限额为 { $cost }
   *[no] 搜索的费用限额为所给试验编排的费用（读数更多时按比例增加）：{ $cost }（--any-cost：不限费用）
}
without-it-nothing-determines = 去掉它则无法确定 { $parameter }
without-it-u-of-grows-by = 去掉它则 { $parameter } 的 u 增大 { $share } %
u-of-their-coefficients-and = 二者系数的 u 为 { $p } 和 { $q }
and-both-in-the-model-before = { $a } 与 { $b } 同在模型中：原编排，{ $before }
with-the-added-positions = 增加位置后，{ $after }
planned-with-columns = 新位置按 { $held } 规划（取自方案中最后一个读数）；请填入实际读数时的值，或用 --candidates 文件 另行给出
positions-share-deviations-planned-for = 读数共有偏差（{ $line }）；所选位置按 { $levels } 规划（扫描采用方案中最后一个读数的值；可用 --candidates 文件 另行给出）
no-candidate-would-separate-it-but-all = 没有候选位置能将其分离；全部候选位置都限于 { $held }（可用 --candidates 文件 另行给出）
of-is-found-with-probability-where-the = 大小为 { $size } 的 { $effect }，当其系数 { $coefficient } 的 u 不大于 { $u } 时，以概率 { $power } 被发现
the-goal-counts = { $some ->
    [yes] 目标所计的量：{ $counted }；不计 { $derived }
   *[no] 目标所计的量：{ $counted }
}
this-is-the-cheapest-schedule-that-was = 这是已找到的费用最低的试验编排；未证明没有更低者
leverage = 杠杆值
no-candidate-discriminates = 没有候选位置能区分 { $a } 与 { $b }，因此不增加位置。
seed-of-starts-ended-here = ，随机种子 { $seed }，{ $starts } 个起点中有 { $hits } 个收敛于此
of-its-readings-chosen-among-candidate-portions = 其中 { $chosen } 个读数选自 { $candidates } 份候选，准则 { $criterion }{ $starts }
better = 更优
gain = 改善倍数
judged-at-2 = 评定点
the-given-schedule = 原试验编排
the-better-schedule-in-full = 更优的试验编排全表
model-and-noise = 模型与噪声
the-better-schedule-2 = 更优的试验编排
goal-not-determined = 目标未达到：所计的量并非都能确定。
goal-reached = { $reached ->
    [yes] 目标已达到：最大不确定度为其限值的 { $share } 倍{ $proof }。
   *[no] 目标未达到：最好时，最大不确定度为其限值的 { $share } 倍。
}
still-to-run-2 = 尚待进行：{ $work }。
predicted-standard-uncertainties = 预计标准不确定度
at-equal-effort = { $cost ->
    [yes] 费用相同：将原试验编排重复或截短，使费用与更优的试验编排相同。
   *[no] 读数相同：将原试验编排重复或截短，使读数数目与更优的试验编排相同。
}
mounting = 安装
in-this-order-a-drift-of-one = 按此顺序，全程线性漂移一倍噪声标准差时，参数至多变化其不确定度的 { $share } 倍。
where-the-positions-lie = 位置分布
squares-the-schedules-positions = 方块：试验编排的各位置。
dots-candidates-squares-the-given-schedule-discs = 小点：候选位置。方块：原试验编排。带数字的圆：更优的试验编排及其在各位置的读数。
then-at-a-reading-in-its-u = 读数的变化，以其 u 计
cannot-be-distinguished-from = 无法区分的项
effects-that-would-show = 可以发现的误差项，每个方向一行
nearly-alike-cosine-beside-the-model-and = 近似相同者：列出扣除模型后的方向余弦，以及前者不致被误认为后者的最小值。
taken-up-by = 吸收它的参数
effects-that-never-show-estimated-parameters-take = 无法发现的误差项：被待估参数吸收，并使其产生偏差
zero-at-every-position = 在各位置上均为零：{ $effects }
not-tried-without-a-column-kinds-of-2 = 缺少 `{ $column }` 列而未试用的误差项类数：{ $families }
effects-of-the-catalogue-were-tried-in = 目录中的误差项 { $tried } 个，扣除模型后互不相同的方向 { $distinct } 个。
what-a-diagnosis-could-find = 诊断所能发现的误差项
not-every-unknown-has-a-predicted-uncertainty = 在评定点上，并非每个参数都有预计不确定度。
every-unknown-can-be-estimated = 各参数均可估计。
each-value-leverage-minimal-detectable-bias-and = 各数据：杠杆值、最小可探测偏差（0.1 %，80 %），以及粗差未被发现时角度的最大改变
averaging-time-s = 平均时间，s
time-since-the-first-sample-s = 自第一个采样起的时间，s
deg-across-deg-up = 横轴 { $across }（deg），纵轴 { $up }（deg）
regressor-of-sensor = { $regressor }（{ $sensor }）
foresight-nearly = 近似 { $regressor }（{ $cosine }）
apart-from = { $regressor }（{ $cosine }，自 { $apart } 起可区分）
none-would-show-the-estimated-parameters-take = 均不能发现：这些位置所激励的误差项全部被待估参数吸收
smallest-size-that-shows-u-significance-for = 可发现的最小值：{ $size } u（各方向合计显著性水平 { $significance }，检验功效 { $power }）；噪声只能由残差得知时：{ $with_residuals }
grouped-by = { $what }（按 { $by } 区分）
gauss-newton-did-not-converge-after = 高斯-牛顿法经 { $steps }仍未收敛：{ $stop }。
reduction-segment = 第 { $segment } 段：{ $notes }。
terms = 术语
meaning = 含义
lot = 批次
control-limits = 控制限
plan-of = 计划：{ $title }
more-rows = { $option ->
    [yes] ……另有 { $n } 行（-v 全部列出）
   *[no] ……另有 { $n } 行
}
nearly-alike = 近似相同
iterations = 迭代过程
weighted-sum-of-squares = 加权平方和
step-of-the-predictions = 预测值的改变（范数）
share-of-the-step = 所取步长比例

# cli/guide/view.rs
guide-position = 位置 { $label }：{ $setting }
guide-newest = 读数 { $reading }，{ $place }：{ $agreement ->
    [agrees] 一致（{ $sd } 倍标准差）
    [disagrees] 不一致，相差 { $sd } 倍标准差
   *[not-predicted] 其余读数尚不能预测它
}
guide-time-goes-back = time_s 从 { $before } 倒退到 { $now }
guide-likely = { "  " }可能的原因：{ $kind }
guide-not-told = { "  " }尚不能判断原因：
guide-undo = { "  " }{ $culprit ->
    [yes] 读数 { $reading } 本身很可能有误（{ $probability }）：“undo { $reading }” 可撤回它
   *[no] “undo” 撤回最后一个读数，“undo N” 撤回读数 N
}；留下的读数计入所有结果
guide-explanation = { "    " }{ $probability }  读数 { $reading }，{ $kind }：{ $what }
guide-goal-open = { "  " }{ $id }：尚不可估计，目标 { $goal } { $unit }
guide-goal = { "  " }{ $id } = { $value } { $unit }，u = { $u }，目标 { $goal }：{ $met ->
    [yes] 已达到
   *[no] 未达到
}
guide-diagnosis = { "  " }诊断：{ $verdict }
guide-effect = { "    " }{ $name }（{ $terms }）{ $size }，概率 { $probability }
guide-nothing-missing = { "  " }无缺项或均已指明的概率 { $probability }；尚不能显现的误差项：{ $unseen }
guide-unreachable = { "  " }{ $id }：这些位置无论测多少次都达不到目标
guide-next = 下一位置：{ $place }（{ $why ->
    [information] 期望信息量 { $nats } 奈特，代价 { $cost }
    [tells-apart] 区分 { $between }
   *[again] 重复同一位置
}）
guide-moving = 台架正在运动
guide-held = { $place }：已保持 { $seconds } s
guide-held-mean = ，{ $sensor } 的 u = { $u } { $unit }（要求 { $wanted }）
guide-held-wait = { $place }：已保持 { $seconds } s{ $means }；还需保持 { $wait } s
guide-held-never = { $place }：已保持 { $seconds } s{ $means }；继续保持达不到要求：输入 'take' 按现状读取
guide-read = { $place }：已读取；请设置下一个位置
guide-left = { $place }：{ $seconds } s 后离开{ $means }，未读取
guide-port-is-back = 串口 { $name } 又接上了
guide-which = 哪个位置？有几个位置与读数相符；请输入一行：position LABEL
  { "  " }{ $candidates }
guide-view-set = 设置
guide-view-held = 保持
guide-view-goals = 目标：u 与目标值
guide-view-residuals = 残差（标准差倍数），按读数
guide-view-missing = 可能缺少的误差项：概率
guide-ended = { $by ->
    [reached] 完成：各目标均已达到，无缺项或均已指明；{ $readings } 个读数，代价 { $cost }
    [nothing-to-gain] 停止：在此方案的各位置继续读数也不能确定尚未确定的问题；{ $readings } 个读数，代价 { $cost }
   *[most-readings] 停止：已取 { $readings } 个读数，为 --most 所允许的上限；代价 { $cost }
}

# Run sheets and drawings of benches
run-sheet = 测量记录表：{ $bench }
run-sheet-how = 按此顺序读数，把每个读数填入空格；同一表的 CSV 形式（--sheet FILE.csv）填好后用 --readings 读入。
mountings = 安装
cost = 费用
cost-so-far = 累计费用
unit-at-the-start = 任务开始时的惯性装置：航向、俯仰、横滚及其摇摆幅度。
heading-angle = 航向
pitch-angle = 俯仰
roll-angle = 横滚
bench-at-first-reading = 第一个读数时的台架：各关节以绕其轴的圆环表示，由地面（外）到被测件（内），倾角取零。红色弧表示转动。
east-axis = 东
north-axis = 北
up-axis = 上
gravity-arrow = 重力
earth-rate-arrow = 地球自转
