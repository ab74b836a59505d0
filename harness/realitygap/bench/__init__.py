"""Servo and link identification: the measuring procedures of the thesis' chapter 4, for any servo and robot.

One module per procedure, each with `run(bench, out) -> Summary`: `servo` (torque-speed lines, static friction and
recordings), `supply` (voltages reported and measured, drop along a chain of motors) and `links` (masses, centres of
mass and inertia tensors of a URDF). A bench file is YAML; its keys are the fields of `ServoBench`, `SupplyBench` and
`LinkBench`. Paths are relative to the file, `${NAME}` is taken from the environment. Every number has a unit: a
quantity is written with it (`7.3 N·m`), a table column has it under `units`. An unknown key, a missing unit or a row
that cannot be used is one sentence.
"""
