/** The same numbers in every run, 0 to 1 (an LCG: Numerical Recipes). */
export function random(seed: number): () => number {
  let state = seed;
  return () => (state = (Math.imul(state, 1664525) + 1013904223) >>> 0) / 2 ** 32;
}
