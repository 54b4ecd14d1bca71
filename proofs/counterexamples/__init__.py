"""Cases in which the text's wording is false, each computed.

A counterexample yields its facts, each a sentence and whether computing it confirmed it.
"""
