"""Gain, phase, delay and disk margins, without a frequency grid."""
