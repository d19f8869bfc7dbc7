"""The material shader: texture look-ups of a `schemas.appearance.material.Material` in VTK's own PBR shader.

VTK binds one image per PBR input, with one set of texture coordinates, fixed channels and per-vertex tangents. Models
here have a channel, wrap mode and transform per input and several UV sets, so the look-ups are generated instead; the
lighting (GGX, Fresnel, image-based light) stays VTK's.
"""

from __future__ import annotations

from dataclasses import dataclass

from schemas.appearance.material import Material, TextureUse

# Lines of VTK's generated fragment shader that the code is anchored to.
_BEFORE_LIGHTING = "vec3 N = normalVCVSOutput;"
_TONE = "fragOutput0.rgb = pow(fragOutput0.rgb, vec3(1.0/2.2));"

_FUNCTIONS = """
float mana_wrap(float t, int mode, int size) {
  float inset = 0.5 / float(size);  // The sampler may repeat, for the sake of the other axis.
  if (mode == 1) return clamp(t, inset, 1.0 - inset);
  if (mode == 2) return 1.0 - abs(mod(t, 2.0) - 1.0);
  return t;
}
vec4 mana_texel(sampler2D image, vec2 uv, int s, int t) {
  bool outside = (s == 3 && (uv.x < 0.0 || uv.x > 1.0)) || (t == 3 && (uv.y < 0.0 || uv.y > 1.0));
  ivec2 size = textureSize(image, 0);
  vec4 texel = texture(image, vec2(mana_wrap(uv.x, s, size.x), mana_wrap(uv.y, t, size.y)));
  return outside ? vec4(0.0) : texel;
}
"""
CLEARED = 0.7  # of the opacity that clear glass loses: it keeps a body that can be seen
_WRAP_MODES = {"repeat": 0, "clamp": 1, "mirror": 2, "black": 3}

# Tangent frame from screen-space derivatives (Schueler, "Normal mapping without precomputed tangents", ShaderX 5):
# right for mirrored and transformed UVs, where VTK's per-vertex tangents have no handedness. Both axes have length 1
# however far the texture is stretched, the tangent lies across the gradient of v (glTF 2.0, 3.7.2.1: MikkTSpace).
_BUMP = """
  {{
    vec3 n_T = ({sample}).xyz * 2.0 - 1.0;
    n_T.xy *= {normal_scale};
    vec3 p1 = dFdx(vertexVC.xyz), p2 = dFdy(vertexVC.xyz);
    vec2 t1 = dFdx({uv}), t2 = dFdy({uv});
    vec3 q1 = cross(normalVCVSOutput, p1), q2 = cross(p2, normalVCVSOutput);
    vec3 u = q2 * t1.x + q1 * t2.x, v = q2 * t1.y + q1 * t2.y;
    float size2 = dot(v, v);
    if (size2 > 0.0) {{
      vec3 B = v * inversesqrt(size2);
      vec3 T = cross(B, normalVCVSOutput) * (dot(cross(u, v), normalVCVSOutput) < 0.0 ? -1.0 : 1.0);
      // Seen from behind, a bump is a dent: the whole tilted normal is reversed (glTF 2.0, 3.9.4, double sided).
      float turn = (dot(cross(p1, p2), normalVCVSOutput) < 0.0) == gl_FrontFacing ? -1.0 : 1.0;
      normalVCVSOutput = normalize((T * n_T.x + B * n_T.y) * turn + normalVCVSOutput * n_T.z);
    }}
  }}
"""

# Highlights roll off above 0.8 instead of clipping; below it the exact sRGB curve (IEC 61966-2-1) of linear light.
_SRGB = """
  {
    vec3 c = fragOutput0.rgb;
    c = mix(c, 1.0 - 0.2 * exp((0.8 - c) / 0.2), step(0.8, c));
    fragOutput0.rgb = mix(12.92 * c, 1.055 * pow(max(c, 1e-6), vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c));
  }
"""


@dataclass(frozen=True)
class TextureSlot:
    """One texture look-up: the material input it feeds, and the vertex attribute that holds its coordinates."""

    input: str
    use: TextureUse
    attribute: str


def texture_uses(material: Material) -> tuple[tuple[str, TextureUse], ...]:
    """The inputs of `material` that have a texture, in a fixed order."""
    pairs = (
        ("base_color", material.base_color_texture),
        ("opacity", material.opacity_texture),
        ("metallic", material.metallic_texture),
        ("roughness", material.roughness_texture),
        ("occlusion", material.occlusion_texture),
        ("emissive", material.emissive_texture),
        ("normal", material.normal_texture),
        ("transmission", material.transmission_texture if material.transmission > 0.0 else None),
    )
    return tuple((name, use) for name, use in pairs if use is not None)


def sampler_name(slot: TextureSlot) -> str:
    """The name under which the texture of `slot` must be bound."""
    return f"mana_{slot.input}"


def vertex_replacements(attributes: dict[str, int]) -> tuple[tuple[str, str], ...]:
    """(old, new) pairs for the vertex shader, which pass `attributes` (name -> number of components) on."""
    declared = "".join(f"in vec{n} {a};\nout vec{n} {a}VS;\n" for a, n in attributes.items())
    passed = "".join(f"  {a}VS = {a};\n" for a in attributes)
    return (
        ("//VTK::Normal::Dec", f"//VTK::Normal::Dec\n{declared}"),
        ("//VTK::Normal::Impl", f"//VTK::Normal::Impl\n{passed}"),
    )


def fragment_replacements(
    material: Material, slots: tuple[TextureSlot, ...], attributes: dict[str, int]
) -> tuple[tuple[str, str], ...]:
    """(old, new) pairs for the fragment shader: inputs are sampled before VTK lights them, colours end as sRGB."""
    declared = "".join(f"in vec{n} {a}VS;\n" for a, n in attributes.items())
    body = "  emissiveColor = manaEmissive;\n"
    if "manaColor" in attributes:
        body += "  albedo *= manaColorVS.rgb;\n  opacity *= manaColorVS.a;\n"
    body += "".join(_lookup(slot, material) for slot in slots if slot.input != "transmission")
    if material.alpha_mode == "mask":
        body += f"  if (opacity < {material.alpha_cutoff:.6f}) discard;\n  opacity = 1.0;\n"
    if material.alpha_mode == "opaque":
        body += "  opacity = opacityUniform;\n"
    body += "".join(_cleared(slot, material) for slot in slots if slot.input == "transmission")
    return (
        ("//VTK::Normal::Dec", f"//VTK::Normal::Dec\n{declared}{_FUNCTIONS if slots else ''}"),
        (_BEFORE_LIGHTING, f"{body}  {_BEFORE_LIGHTING}"),
        (_TONE, _SRGB),
    )


def _cleared(slot: TextureSlot, material: Material) -> str:
    """The GLSL statement by which glass, where the texture has some, becomes clear; its colour is that of the base."""
    return f"  opacity *= 1.0 - {CLEARED * material.transmission:.6f} * {_adjusted(slot)}.{_channel(slot.use)};\n"


def _texel(slot: TextureSlot) -> str:
    use = slot.use
    return f"mana_texel({sampler_name(slot)}, {slot.attribute}VS, {_WRAP_MODES[use.wrap_s]}, {_WRAP_MODES[use.wrap_t]})"


def _adjusted(slot: TextureSlot) -> str:
    return f"({_texel(slot)} * {slot.use.scale:.6f} + {slot.use.bias:.6f})"


def _channel(use: TextureUse) -> str:
    return "r" if use.channel == "rgb" else use.channel


def _lookup(slot: TextureSlot, material: Material) -> str:
    """The GLSL statements by which `slot` changes its input."""
    use = slot.use
    if slot.input == "normal":
        uv = f"{slot.attribute}VS"
        return _BUMP.format(sample=_texel(slot), uv=uv, normal_scale=f"{material.normal_scale:.6f}")
    adjusted = _adjusted(slot)
    colour = f"{adjusted}.{'rgb' if use.channel == 'rgb' else use.channel * 3}"
    scalar = f"{adjusted}.{_channel(use)}"
    return {
        "base_color": f"  albedo *= {colour};\n",
        "opacity": f"  opacity *= {scalar};\n",
        "metallic": f"  metallic *= {scalar};\n",
        "roughness": f"  roughness *= {scalar};\n",
        "occlusion": f"  ao *= {scalar};\n",
        "emissive": f"  emissiveColor *= {colour};\n",
    }[slot.input]
