import { describe, expect, it } from 'vitest';
import { formatLink, parseLink } from './deep_link.ts';
import { degrees } from '../geometry/geometry.ts';

describe('deep links', () => {
  it('go there and back', () => {
    const place = { scan: 'home 1', viewpoint: 'a/b', heading: degrees(123.4), elevation: degrees(-12.5) };
    expect(formatLink(place)).toBe('#home%201/a%2Fb/123.4/-12.5');
    const back = parseLink(formatLink(place))!;
    expect(back.scan).toBe('home 1');
    expect(back.viewpoint).toBe('a/b');
    expect(back.heading).toBeCloseTo(place.heading, 10);
    expect(back.elevation).toBeCloseTo(place.elevation, 10);
  });

  it('may end anywhere', () => {
    expect(parseLink('#s')).toEqual({ scan: 's' });
    expect(parseLink('#s/v')).toEqual({ scan: 's', viewpoint: 'v' });
    expect(parseLink('')).toBeUndefined();
    expect(parseLink('#/v')).toBeUndefined();
  });

  it('leave out what makes no sense', () => {
    expect(parseLink('#s/v/north/1e9')).toEqual({ scan: 's', viewpoint: 'v' });
    expect(parseLink('#s/v/0/400')!.elevation).toBeCloseTo(Math.PI / 2);
    expect(parseLink('#%E0%A4%A')).toBeUndefined();
  });
});
