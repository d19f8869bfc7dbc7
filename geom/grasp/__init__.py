"""Parallel-jaw grasps on a surface: gripper model, antipodal pairs, contact patches."""
