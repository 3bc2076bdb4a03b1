"""The buildings in data/, and the kit that they are made with."""
