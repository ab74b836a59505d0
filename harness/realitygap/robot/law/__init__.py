"""The compiled drive law, by purpose: controller, supply, motor, friction, transmission, springs, effort map."""
