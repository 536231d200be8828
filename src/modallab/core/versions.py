"""Versions of every format the project writes. Old ones stay readable for ever."""

RIG = 2
CAMPAIGN_INT16 = 1
CAMPAIGN_NATIVE = 2
MODEL = 1
STORE = 3
SAMPLES = 1
DIAGNOSIS = 2
PREDICTION = 2
MODAL_DIAGNOSIS = 1
