# Projection pursuit regression of R's own package on SAMPLES.csv files, the paper's tool for what `fit`
# does: for each file its error (mean |fitted - data| / mean data, on the mean of the channels) and the
# seconds that the fit alone took. Arguments: terms, max.terms, files.
a <- commandArgs(trailingOnly = TRUE)
for (file in a[-(1:2)]) {
  d <- read.csv(file)
  x <- as.matrix(d[, c("nx", "ny", "nz")])
  y <- if ("value" %in% names(d)) d$value else (d$r + d$g + d$b) / 3
  seconds <- system.time(p <- ppr(x, y, nterms = as.integer(a[1]), max.terms = as.integer(a[2]),
                                  sm.method = "supsmu"))[["elapsed"]]
  cat(file, length(y), mean(abs(fitted(p) - y)) / mean(y), seconds, "\n")
}
