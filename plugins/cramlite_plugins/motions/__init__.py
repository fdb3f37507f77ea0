"""Motion resolvers: each turns a kind of motion designator into program steps."""
