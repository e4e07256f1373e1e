import { describe, expect, it } from 'vitest';
import { everyDay } from './day_chart.ts';

const day = (name: string, submitted = 1) => ({ day: name, submitted, reviewed: 0 });

describe('days', () => {
  it('without work are among them', () => {
    expect(everyDay([day('2026-02-27', 3), day('2026-03-01', 2)])).toEqual([day('2026-02-27', 3), day('2026-02-28', 0), day('2026-03-01', 2)]);
    expect(everyDay([day('2026-02-27')])).toEqual([day('2026-02-27')]);
    expect(everyDay([])).toEqual([]);
  });
  it('of a long study are the last ones', () => {
    const found = everyDay([day('2020-01-01'), day('2026-03-01', 2)], 3);
    expect(found.map((one) => one.day)).toEqual(['2026-02-27', '2026-02-28', '2026-03-01']);
    expect(found.at(-1)!.submitted).toBe(2);
  });
});
