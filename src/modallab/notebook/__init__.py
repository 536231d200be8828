"""modallab for people at a notebook or a prompt: a few functions over the pipelines, whose results show themselves."""
