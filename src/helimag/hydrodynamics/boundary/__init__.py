"""The Stokes resistance of a rigid body from its surface: helix, head, or any closed mesh, in open water or beside a plane."""
