"""Things on joints: grasps of handles and levers, paths along a joint, and what is in the way of these."""
