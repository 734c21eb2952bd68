"""Run tasks in a pool of processes or on a cluster; compile kernels before many scenes are run."""
