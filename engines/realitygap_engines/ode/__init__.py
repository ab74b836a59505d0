"""ODE, the thesis' engine, through its C library."""
