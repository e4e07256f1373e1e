/** Workers describe paths: `/collect?collection=NAME&key=K`, and what the platforms add. */
import { work } from '../work/flow.ts';
import { WriteTask } from '../work/write_task.ts';

work('write', async (main, desk) => {
  const task = await WriteTask.open(main, desk);
  return () => task.dispose();
});
