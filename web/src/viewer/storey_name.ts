/** For people. */
export const storeyName = (storey: number): string => (storey === 0 ? 'Ground floor' : `Floor ${storey}`);
