"""The Stokes resistance of a rigid body from its surface: wire and head, or any closed mesh."""
