/* RCAC_SW and RCAC_LAMBDA act on the running controller; what else the published class takes as
 * parameters (P0, N_nf, Ru) is fixed by the export. */

/**
 * Adaptation switched on
 *
 * @boolean
 * @group RCAC
 */
PARAM_DEFINE_INT32(RCAC_SW, 1);

/**
 * Forgetting factor
 *
 * @min 0.5
 * @max 1.0
 * @decimal 4
 * @group RCAC
 */
PARAM_DEFINE_FLOAT(RCAC_LAMBDA, @LAMBDA@);
