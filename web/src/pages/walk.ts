/** Workers follow instructions: `/walk?collection=NAME&key=K`, and what the platforms add. */
import { work } from '../work/flow.ts';
import { WalkTask } from '../work/walk_task.ts';

declare global {
  interface Window {
    /** For tests. */
    walkTask?: WalkTask;
  }
}

work('walk', async (main, desk) => {
  const task = await WalkTask.open(main, desk);
  window.walkTask = task;
  return task;
});
