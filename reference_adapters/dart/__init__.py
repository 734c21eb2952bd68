"""DART as a reference engine: impacts and friction as one boxed linear complementarity problem."""
