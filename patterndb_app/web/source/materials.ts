/** Materials of the scene: shaded faces, lines of a width in pixels, markers with crisp rims. */

import {
  Color,
  DoubleSide,
  type Material,
  MeshLambertMaterial,
  ShaderMaterial,
  Vector2,
  type WebGLProgramParametersWithUniforms,
} from "three";
import { LineMaterial } from "three/examples/jsm/lines/LineMaterial.js";

/**
 * How much nearer to the viewer a layer is drawn than it lies, per layer, in clip space.
 *
 * A fill's quads cut into a curved surface; lines lie in the quads. Shifted depth keeps them
 * visible, and their place on the screen is what it is. Scene sets it at every picture.
 */
export const lift = { value: 0 };

/** The size of the canvas in pixels, which lines and markers need; shared by all. */
export const resolution = new Vector2(1, 1);
export const pixelRatio = { value: 1 };

/** The layers from the ground up. */
export const LAYER = { surface: 0, mesh: 0.35, fill: 1, edge: 1.6, boundary: 2, stroke: 2.4, marker: 3 };

const SHIFT = "#include <logdepthbuf_vertex>";

function raise<M extends Material>(material: M, layer: number): M {
  material.onBeforeCompile = (shader: WebGLProgramParametersWithUniforms): void => {
    shader.uniforms.lift = lift;
    shader.uniforms.layer = { value: layer };
    shader.vertexShader = `uniform float lift;\nuniform float layer;\n${shader.vertexShader.replace(
      SHIFT,
      `${SHIFT}\n\tgl_Position.z -= lift * layer;`,
    )}`;
  };
  // One program for all layers: their number is a uniform of each material.
  material.customProgramCacheKey = () => "raised";
  return material;
}

/**
 * Materials that were made, by what they are made of.
 *
 * They are never given up: with the last material of a kind its program would go, and compiling
 * one anew for the next fill takes longer than drawing it.
 */
const made = new Map<string, Material>();

function remember<M extends Material>(key: readonly unknown[], make: () => M): M {
  const name = key.join(" ");
  const known = made.get(name) ?? make();
  made.set(name, known);
  return known as M;
}

export function findFaceMaterial(colour: string, layer: number, tinted = false): MeshLambertMaterial {
  const shown = tinted ? "#ffffff" : colour;
  return remember(["face", shown, layer, tinted], () =>
    raise(new MeshLambertMaterial({ color: new Color(shown), vertexColors: tinted, side: DoubleSide }), layer),
  );
}

export function findLineMaterial(colour: string, width: number, layer: number): LineMaterial {
  return remember(["line", colour, width, layer], () => {
    const material = new LineMaterial({ color: new Color(colour).getHex(), linewidth: width });
    material.resolution = resolution;
    return raise(material, layer);
  });
}

/** Markers: a regular polygon of `sides` corners, a disc for fewer than 3, a star from 7 on. */
export function findMarkerMaterial(rim: string, layer: number): ShaderMaterial {
  return remember(["marker", rim, layer], () => makeMarkerMaterial(rim, layer));
}

function makeMarkerMaterial(rim: string, layer: number): ShaderMaterial {
  return new ShaderMaterial({
    transparent: true,
    depthWrite: false,
    uniforms: { lift, layer: { value: layer }, rim: { value: new Color(rim) }, ratio: pixelRatio },
    vertexShader: `
      attribute vec3 tint;
      attribute float sides;
      attribute float radius;
      uniform float lift, layer, ratio;
      varying vec3 vTint;
      varying float vSides, vRadius;
      void main() {
        gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
        gl_Position.z -= lift * layer;
        vTint = tint;
        vSides = sides;
        vRadius = radius * ratio;
        gl_PointSize = 2.0 * (vRadius * 1.3 + 2.5 * ratio);
      }`,
    fragmentShader: `
      uniform vec3 rim;
      uniform float ratio;
      varying vec3 vTint;
      varying float vSides, vRadius;
      float outline(vec2 p) {
        float r = length(p);
        if (vSides < 2.5) return r - vRadius;
        float sector = 3.14159265 / vSides;
        float a = mod(atan(p.x, p.y) + sector, 2.0 * sector) - sector;
        if (vSides < 6.5) {
          float grown = vRadius * (vSides < 3.5 ? 1.22 : 1.06);
          return r * cos(sector - abs(a)) - grown * cos(sector);
        }
        vec2 q = r * vec2(sin(abs(a)), cos(a));
        vec2 tip = vec2(0.0, 1.25 * vRadius);
        vec2 notch = 0.62 * vRadius * vec2(sin(sector), cos(sector));
        vec2 along = notch - tip;
        return dot(q - tip, normalize(vec2(-along.y, along.x)));
      }
      void main() {
        vec2 p = (gl_PointCoord - 0.5) * 2.0 * (vRadius * 1.3 + 2.5 * ratio) * vec2(1.0, -1.0);
        float d = outline(p);
        float width = 1.4 * ratio;
        float alpha = 1.0 - smoothstep(width - 0.7, width + 0.7, d);
        if (alpha < 0.01) discard;
        gl_FragColor = vec4(mix(vTint, rim, smoothstep(-0.7, 0.7, d)), alpha);
        #include <colorspace_fragment>
      }`,
  });
}
