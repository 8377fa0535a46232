"""What a MultibodyPlant says of its bodies: names, geometry, materials, pairs."""
