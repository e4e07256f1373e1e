import { describe, expect, it } from 'vitest';
import { applyCorrections, type Correction, correctionsFile } from './corrections.ts';
import { readScan, vectorsFolder } from '../testing/vectors.ts';

const scan = readScan(`${vectorsFolder}data/connectivity`, 'triangle');
const correction = (action: Correction['action'], from: string, to?: string): Correction => ({
  action, from, ...(to && { to }), who: 'Ada', why: 'a rope', when: '2026-05-01',
});
const edges = (list: readonly Correction[]) =>
  applyCorrections(scan, list).viewpoints.map((v) => [...v.neighbours].sort());

describe('corrections', () => {
  const before = edges([]);

  it('of nothing change nothing', () => {
    expect(before).toEqual(scan.viewpoints.map((v) => [...v.neighbours].sort()));
  });

  it('take an edge away in both directions, and bring it back', () => {
    const without = edges([correction('remove-edge', 'v0', 'v1')]);
    expect(without[0]).not.toContain(1);
    expect(without[1]).not.toContain(0);
    expect(edges([correction('remove-edge', 'v0', 'v1'), correction('add-edge', 'v1', 'v0')])).toEqual(before);
  });

  it('leave a viewpoint out with all its edges, until it is taken in again', () => {
    const without = edges([correction('exclude', 'v1')]);
    expect(without[1]).toEqual([]);
    expect(without.flat()).not.toContain(1);
    expect(edges([correction('exclude', 'v1'), correction('include', 'v1')])).toEqual(before);
  });

  it('of unknown viewpoints are refused', () => {
    expect(() => edges([correction('exclude', 'v9')])).toThrow('no viewpoint v9');
  });

  it('are written as the C++ reads them', () => {
    expect(JSON.parse(correctionsFile('triangle', [correction('exclude', 'v1')]))).toEqual({
      scan: 'triangle',
      corrections: [{ action: 'exclude', from: 'v1', who: 'Ada', why: 'a rope', when: '2026-05-01' }],
    });
  });
});
