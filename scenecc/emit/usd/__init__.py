"""One scene as USD: what is seen, and bodies, colliders and joints as UsdPhysics has them."""
