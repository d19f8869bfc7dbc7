"""Parallel-jaw grasps on a surface (metres, newtons): gripper model, antipodal pairs, contact patches."""
