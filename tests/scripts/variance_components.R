# Published variance components, anew: lme4's Dyestuff and Penicillin, nlme's Rail, by lme4 itself.
# Writes tests/data/scatter/lme4.json (Debian: r-cran-lme4, r-cran-nlme). Run: Rscript tests/scripts/variance_components.R
suppressPackageStartupMessages({library(lme4); library(nlme)})
data(Dyestuff, package = "lme4"); data(Penicillin, package = "lme4"); data(Rail, package = "nlme")
tight <- lmerControl(optCtrl = list(xtol_rel = 1e-14, ftol_rel = 1e-15, ftol_abs = 1e-15, xtol_abs = 1e-14, maxeval = 1e5))
out <- function(name, fit, y, factors) {
  v <- as.data.frame(VarCorr(fit)); x <- summary(fit)$coefficients
  list(name = name, y = y, factors = lapply(factors, function(f) as.integer(factor(f)) - 1L),
       sd = setNames(as.list(v$sdcor), v$grp), intercept = x[1, 1], se = x[1, 2], reml = as.numeric(REMLcrit(fit)))
}
cases <- list(
  out("Dyestuff", lmer(Yield ~ 1 + (1 | Batch), Dyestuff, control = tight), Dyestuff$Yield, list(Batch = Dyestuff$Batch)),
  out("Rail", lmer(travel ~ 1 + (1 | Rail), as.data.frame(Rail), control = tight), Rail$travel, list(Rail = as.character(Rail$Rail))),
  out("Penicillin", lmer(diameter ~ 1 + (1 | plate) + (1 | sample), Penicillin, control = tight), Penicillin$diameter,
      list(plate = Penicillin$plate, sample = Penicillin$sample)))
json <- function(x) {
  if (is.list(x) && !is.null(names(x))) paste0("{", paste0("\"", names(x), "\": ", sapply(x, json), collapse = ", "), "}")
  else if (is.list(x)) paste0("[", paste(sapply(x, json), collapse = ",\n"), "]")
  else if (is.character(x)) paste0("\"", x, "\"")
  else if (length(x) == 1) format(x, digits = 15)
  else paste0("[", paste(sapply(x, format, digits = 15), collapse = ", "), "]")
}
writeLines(json(cases), "tests/data/scatter/lme4.json")
for (case in cases) cat(case$name, unlist(case$sd), case$intercept, case$se, case$reml, "\n")
