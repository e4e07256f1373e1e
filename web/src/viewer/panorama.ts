/** One viewpoint's panorama as a box around its eye, and the cache of its pictures. */
import * as three from 'three';
import { type Mat3, type Vec3, transpose } from '../geometry.ts';
import type { Api, Layer } from '../scan.ts';

/**
 * With g = -(direction in the panorama frame), these faces are OpenGL's +X -X +Y -Y +Z -Z as they
 * are: no picture has to be turned. It is MatterSim's assignment.
 */
const cubeOrder = [2, 4, 0, 5, 1, 3] as const;

/** Half the box's edge, metres. Matters in a glide only, when the eye is off the middle. */
const roomSize = 4;

const vertexShader = /* glsl */ `
  out vec3 ray;
  void main() {
    ray = position;
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  }`;

const fragmentShader = /* glsl */ `
  in vec3 ray;
  out vec4 colour;
  uniform samplerCube picture;
  uniform samplerCube overlay;
  uniform float overlayShare;
  uniform float opacity;
  uniform mat3 panoramaFromWorld;
  void main() {
    vec3 g = -(panoramaFromWorld * ray);
    colour = vec4(mix(texture(picture, g).rgb, texture(overlay, g).rgb, overlayShare), opacity);
  }`;

export class PanoramaBox {
  readonly mesh: three.Mesh<three.BoxGeometry, three.ShaderMaterial>;
  private readonly uniforms = {
    picture: { value: null as three.CubeTexture | null },
    overlay: { value: null as three.CubeTexture | null },
    overlayShare: { value: 0 },
    opacity: { value: 1 },
    panoramaFromWorld: { value: new three.Matrix3() },
  };

  constructor(renderOrder: number) {
    this.mesh = new three.Mesh(
      new three.BoxGeometry(2 * roomSize, 2 * roomSize, 2 * roomSize),
      new three.ShaderMaterial({
        glslVersion: three.GLSL3,
        vertexShader,
        fragmentShader,
        uniforms: this.uniforms,
        side: three.BackSide,
        transparent: true,
        depthTest: false,
        depthWrite: false,
      }),
    );
    this.mesh.renderOrder = renderOrder;
    this.mesh.visible = false;
  }

  show(position: Vec3, worldFromPanorama: Mat3, picture: three.CubeTexture): void {
    this.mesh.position.set(...position);
    this.uniforms.panoramaFromWorld.value.set(...transpose(worldFromPanorama));
    this.uniforms.picture.value = picture;
    this.uniforms.overlay.value = picture;
    this.uniforms.overlayShare.value = 0;
    this.mesh.visible = true;
  }

  setOverlay(overlay: three.CubeTexture | undefined, share: number): void {
    this.uniforms.overlay.value = overlay ?? this.uniforms.picture.value;
    this.uniforms.overlayShare.value = overlay ? share : 0;
  }

  setOpacity(opacity: number): void {
    this.uniforms.opacity.value = opacity;
    this.mesh.visible = opacity > 0;
  }

  dispose(): void {
    this.mesh.geometry.dispose();
    this.mesh.material.dispose();
  }
}

/** Pictures of viewpoints as textures, the latest used ones; a fetch at a time for each. */
export class Pictures {
  private readonly api: Api;
  private readonly scan: string;
  private readonly kept = new Map<string, Promise<three.CubeTexture>>();
  private readonly most = 16;

  constructor(api: Api, scan: string) {
    this.api = api;
    this.scan = scan;
  }

  get(viewpoint: string, layer: Layer): Promise<three.CubeTexture> {
    const key = `${layer}/${viewpoint}`;
    const known = this.kept.get(key);
    const texture = known ?? this.fetch(viewpoint, layer);
    this.kept.delete(key); // to the end: the map's order is that of use
    this.kept.set(key, texture);
    if (!known) {
      texture.catch(() => this.kept.delete(key)); // another look may succeed
      this.forgetOldest();
    }
    return texture;
  }

  dispose(): void {
    for (const texture of this.kept.values()) void texture.then((t) => t.dispose()).catch(() => {});
    this.kept.clear();
  }

  private forgetOldest(): void {
    for (const [key, texture] of this.kept) {
      if (this.kept.size <= this.most) return;
      this.kept.delete(key);
      // What is on the screen right now is uploaded anew should it have been this one.
      void texture.then((t) => t.dispose()).catch(() => {});
    }
  }

  private async fetch(viewpoint: string, layer: Layer): Promise<three.CubeTexture> {
    const bitmaps = await Promise.all(
      cubeOrder.map(async (face) => {
        const response = await fetch(this.api.face(this.scan, viewpoint, layer, face));
        if (!response.ok) throw new Error(`no ${layer} picture of viewpoint ${viewpoint}`);
        return createImageBitmap(await response.blob(), {
          colorSpaceConversion: 'none',
          premultiplyAlpha: 'none',
        });
      }),
    );
    const texture = new three.CubeTexture(bitmaps);
    texture.colorSpace = three.NoColorSpace; // the very values of the file reach the screen
    texture.generateMipmaps = false; // as the simulator filters
    // Classes must not be mixed into colours that stand for other classes.
    const filter = layer === 'colour' ? three.LinearFilter : three.NearestFilter;
    texture.minFilter = filter;
    texture.magFilter = filter;
    texture.needsUpdate = true;
    return texture;
  }
}
