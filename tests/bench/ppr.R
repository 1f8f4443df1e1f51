# Projection pursuit regression of R's own package on a table of normals and radiance: the paper's
# tool for what `estimate` does. Prints the seconds that the fit alone took, reading aside.
table <- read.csv(commandArgs(trailingOnly = TRUE)[1])
x <- as.matrix(table[, c("nx", "ny", "nz")])
cat(system.time(ppr(x, table$value, nterms = 2, max.terms = 5))[["elapsed"]], "\n")
