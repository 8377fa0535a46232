"""Drake systems that put the contact toolkit into a multibody plant."""
