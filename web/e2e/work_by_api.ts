/** Workers and reviewers as scripts at the API: what their pages send. */
import type { Task, Visit } from '../src/work/visit.ts';

export async function ask<T>(address: string, method: string, body: object, token = ''): Promise<T> {
  const headers = { 'Content-Type': 'application/json', ...(token && { Authorization: `Bearer ${token}` }) };
  const response = await fetch(address, { method, headers, body: JSON.stringify(body) });
  if (!response.ok) throw new Error(`${method} ${address}: ${await response.text()}`);
  return (await response.json()) as T;
}

/** One worker does all that is to be done. Returns how many tasks that were. */
export async function work(link: string, answer: (task: Task) => object): Promise<number> {
  const { origin, searchParams } = new URL(link);
  const api = `${origin}/api/v1`;
  const { token } = await ask<{ token: string }>(`${api}/collections/${searchParams.get('collection')}/join`, 'POST',
    { parameters: Object.fromEntries(searchParams) });
  await ask(`${api}/visit/consent`, 'PUT', {}, token);
  for (let done = 0; ; ++done) {
    const { task } = await ask<Visit>(`${api}/visit/task`, 'POST', {}, token);
    if (!task) return done;
    await ask(`${api}/tasks/${task.task}/submission`, 'PUT', answer(task), token);
  }
}
