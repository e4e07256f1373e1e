/** Whose rows are "yours": those of the team that is logged in, or that submitted last in this browser. */
import type { Who } from '../elements/forms.ts';

const key = 'enfilade-team';

export function rememberTeam(name: string): void {
  try {
    localStorage.setItem(key, name);
  } catch {
    // the browser keeps nothing: a login tells
  }
}

/** The team's name; nothing if none is known. */
export function ownTeam({ role, name }: Who): string | undefined {
  if (role === 'team') return name;
  try {
    return localStorage.getItem(key) ?? undefined;
  } catch {
    return undefined;
  }
}
