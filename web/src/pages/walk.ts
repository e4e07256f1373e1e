/** Workers follow instructions, find objects, talk: `/walk?collection=NAME&key=K`, and what the platforms add. */
import { DialogueTask } from '../work/dialogue_task.ts';
import { FindTask } from '../work/find_task.ts';
import { work } from '../work/flow.ts';
import { WalkTask } from '../work/walk_task.ts';

declare global {
  interface Window {
    /** For tests. */
    walkTask?: WalkTask | DialogueTask;
  }
}

work({
  walk: async (main, desk) => (window.walkTask = await WalkTask.open(main, desk)),
  find: async (main, desk) => (window.walkTask = await FindTask.open(main, desk)),
  dialogue: async (main, desk) => (window.walkTask = await DialogueTask.open(main, desk)),
});
