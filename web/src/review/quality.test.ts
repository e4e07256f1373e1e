import { describe, expect, it } from 'vitest';
import { numbersOf } from './quality.ts';

describe('agreement', () => {
  it('of texts', () => {
    expect(numbersOf({ measure: 'token-f1', items: 8, pairs: 24, mean: 0.343, others: 0.2, least: [] })).toEqual([
      ['Token F1 of texts of a path', '0.34'], ['Token F1 of texts of two paths', '0.20'], ['Compared', '24 pairs of 8 items']]);
  });
  it('of walks', () => {
    expect(numbersOf({ measure: 'same-outcome', items: 1, pairs: 3, mean: 1 / 3, success: 2 / 3, metres: 3.333, least: [] })).toEqual([
      ['Pairs with the same outcome', '33 %'], ['Success rate', '67 %'], ['Mean difference of the distance to the goal', '3.3 m'],
      ['Compared', '3 pairs of 1 item']]);
    expect(numbersOf({ measure: 'same-outcome', items: 0, pairs: 0, mean: null, success: null, metres: null, least: [] }))
      .toEqual([['Compared', '0 pairs of 0 items']]);
  });
});
