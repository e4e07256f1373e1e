/**
 * Frames and angles, as in docs/conventions.md: world in metres, z up; headings in radians clockwise
 * from +y; elevations above the horizon. The panorama frame is x right, y down, z forward.
 */

export type Vec3 = readonly [number, number, number];
/** 3 x 3, row-major; named by what it maps, as `worldFromPanorama`. */
export type Mat3 = readonly [
  number, number, number,
  number, number, number,
  number, number, number,
];

/** An agent's view: radians. */
export interface Direction {
  readonly heading: number;
  readonly elevation: number;
}

/** A camera's picture: pixels, and its vertical opening in radians. */
export interface Camera {
  readonly width: number;
  readonly height: number;
  readonly vfov: number;
}

export const degrees = (value: number): number => (value * Math.PI) / 180;
export const toDegrees = (radians: number): number => (radians * 180) / Math.PI;

/** The same heading in [0, 2 pi). */
export function wrapHeading(heading: number): number {
  const turn = 2 * Math.PI;
  const wrapped = heading - turn * Math.floor(heading / turn);
  return wrapped >= turn ? 0 : wrapped; // a tiny negative angle rounds up to a whole turn
}

/** The same angle in (-pi, pi]: the shorter way to turn. */
export function wrapDifference(angle: number): number {
  const wrapped = wrapHeading(angle);
  return wrapped > Math.PI ? wrapped - 2 * Math.PI : wrapped;
}

export const add = (a: Vec3, b: Vec3): Vec3 => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const subtract = (a: Vec3, b: Vec3): Vec3 => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const scale = (k: number, v: Vec3): Vec3 => [k * v[0], k * v[1], k * v[2]];
export const norm = (v: Vec3): number => Math.hypot(v[0], v[1], v[2]);
export const mix = (a: Vec3, b: Vec3, t: number): Vec3 => add(a, scale(t, subtract(b, a)));

export const transpose = (m: Mat3): Mat3 => [
  m[0], m[3], m[6],
  m[1], m[4], m[7],
  m[2], m[5], m[8],
];
export const apply = (m: Mat3, v: Vec3): Vec3 => [
  m[0] * v[0] + m[1] * v[1] + m[2] * v[2],
  m[3] * v[0] + m[4] * v[1] + m[5] * v[2],
  m[6] * v[0] + m[7] * v[1] + m[8] * v[2],
];

/** Camera frame -> world: the columns are the camera's right, down and forward. */
export function worldFromCamera({ heading, elevation }: Direction): Mat3 {
  const [sh, ch] = [Math.sin(heading), Math.cos(heading)];
  const [se, ce] = [Math.sin(elevation), Math.cos(elevation)];
  return [
    ch, sh * se, sh * ce,
    -sh, ch * se, ch * ce,
    0, -ce, se,
  ];
}

/** A direction as a unit vector of the world frame. */
export const unitVector = ({ heading, elevation }: Direction): Vec3 =>
  [Math.sin(heading) * Math.cos(elevation), Math.cos(heading) * Math.cos(elevation), Math.sin(elevation)];

/** Where one looks from `from` to see `to`. */
export function directionTo(from: Vec3, to: Vec3): Direction {
  const [dx, dy, dz] = subtract(to, from);
  return { heading: wrapHeading(Math.atan2(dx, dy)), elevation: Math.atan2(dz, Math.hypot(dx, dy)) };
}

/**
 * Where a point is in the picture: pixels from the top left corner, or nothing if it is behind the
 * camera.
 */
export function project(
  camera: Camera,
  direction: Direction,
  eye: Vec3,
  point: Vec3,
): readonly [number, number] | undefined {
  const [x, y, z] = apply(transpose(worldFromCamera(direction)), subtract(point, eye));
  if (z <= 1e-6) return undefined;
  const focal = camera.height / 2 / Math.tan(camera.vfov / 2);
  return [camera.width / 2 + (focal * x) / z, camera.height / 2 + (focal * y) / z];
}
