"""The cantilever as a model: finite elements, measurement chain, effects, prediction of records."""
