"""The controller model of an arm and its gripper: motion, force mode, stops, sensors."""
