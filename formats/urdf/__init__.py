"""URDF (wiki.ros.org/urdf/XML): `read` and `write`, with the additions of PyBullet (`<contact>`) and Drake."""
