import { describe, expect, it } from 'vitest';
import {
  apply, type Camera, degrees, directionTo, project, toDegrees, transpose, type Vec3,
  worldFromCamera, wrapDifference, wrapHeading,
} from './geometry.ts';

const close = (a: Vec3, b: Vec3) => a.forEach((x, k) => expect(x).toBeCloseTo(b[k]!, 12));

describe('angles', () => {
  it('wrap', () => {
    expect(wrapHeading(-0.5)).toBeCloseTo(2 * Math.PI - 0.5);
    expect(wrapHeading(2 * Math.PI)).toBe(0);
    expect(wrapHeading(-1e-20)).toBe(0);
    expect(wrapDifference(degrees(350))).toBeCloseTo(degrees(-10));
    expect(wrapDifference(Math.PI)).toBe(Math.PI);
    expect(toDegrees(degrees(33))).toBeCloseTo(33);
  });
});

describe('worldFromCamera', () => {
  it('has right, down and forward as columns', () => {
    const ahead: Vec3 = [0, 0, 1];
    close(apply(worldFromCamera({ heading: 0, elevation: 0 }), ahead), [0, 1, 0]);
    close(apply(worldFromCamera({ heading: Math.PI / 2, elevation: 0 }), ahead), [1, 0, 0]);
    close(apply(worldFromCamera({ heading: 1, elevation: Math.PI / 2 }), ahead), [0, 0, 1]);
    close(apply(worldFromCamera({ heading: 0, elevation: 0 }), [1, 0, 0]), [1, 0, 0]);
    close(apply(worldFromCamera({ heading: 0, elevation: 0 }), [0, 1, 0]), [0, 0, -1]);
  });

  it('is a rotation', () => {
    const m = worldFromCamera({ heading: 2.1, elevation: -0.4 });
    for (const v of [[1, 0, 0], [0, 1, 0], [0, 0, 1]] as Vec3[]) {
      close(apply(transpose(m), apply(m, v)), v);
    }
  });
});

describe('project', () => {
  const camera: Camera = { width: 640, height: 480, vfov: degrees(60) };

  it('puts what one looks at in the middle', () => {
    const direction = directionTo([1, 2, 1.5], [3, 5, 0.2]);
    const [x, y] = project(camera, direction, [1, 2, 1.5], [3, 5, 0.2])!;
    expect(x).toBeCloseTo(320);
    expect(y).toBeCloseTo(240);
  });

  it('has the upper edge half an opening above', () => {
    const up = Math.tan(degrees(30));
    const [x, y] = project(camera, { heading: 0, elevation: 0 }, [0, 0, 0], [0, 1, up])!;
    expect([x, y]).toEqual([320, expect.closeTo(0)]);
  });

  it('knows nothing of what is behind', () => {
    expect(project(camera, { heading: 0, elevation: 0 }, [0, 0, 0], [0, -1, 0])).toBeUndefined();
  });
});
