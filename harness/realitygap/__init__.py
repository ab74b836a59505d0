"""realitygap: one scenario through many physics engines, compared with recordings of the real robot."""
