/* How probable so large a misfit is where nothing is wrong.
 *
 * T is a sum of squares of `dof` standard normal deviates, measured in units of a noise that is
 * known from `noise_dof` residuals: T / dof is F(dof, noise_dof). With noise_dof = HUGE_VAL the noise
 * is known and T is chi-squared. */
#ifndef HL_SIGNIFICANCE_H
#define HL_SIGNIFICANCE_H

/* Probability of at least `t`; 1 for t <= 0 or dof <= 0, NaN for NaN. */
double hl_significance(double t, double dof, double noise_dof);

/* The t that is reached with probability `rate`, 0 < rate < 1, dof > 0. */
double hl_significance_limit(double rate, double dof, double noise_dof);

#endif
