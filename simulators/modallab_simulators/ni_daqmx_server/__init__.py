"""NI's gRPC device server, simulated: the wire protocol of the real one, with the simulated cantilever behind it.

It runs in a process of its own (`python -m modallab_simulators.ni_daqmx_server`), so that, as on a real one, tasks and
outputs go on when a client dies. The real `nidaqmx` package speaks to it unchanged.
"""
