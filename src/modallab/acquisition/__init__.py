"""The acquisition process: triggers, hit acceptance, sine plan, recorder, limits."""
