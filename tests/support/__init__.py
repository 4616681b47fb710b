"""What tests share: oracles, small models, compilers, browsers and machines."""
