/** The building of what is reviewed: its path or walk, its object, its map. */
import type { Work } from '../collecting/collections.ts';
import { viewpointIndex } from '../scan/scan.ts';
import { api } from '../server/api.ts';
import { MiniMap, Outlines, Player, Viewer } from '../viewer/enfilade-viewer.ts';
import { outlinesIn } from '../work/targets.ts';

/** Kept while the next work is in the same building. */
export class Stage {
  private readonly view: HTMLElement;
  private readonly mapBox: HTMLElement;
  private viewer: Viewer | undefined;
  private map: MiniMap | undefined;
  private player: Player | undefined;
  private outlines: Outlines | undefined;
  /** One work after another: the viewer is opened and turned for each. */
  private showing: Promise<unknown> = Promise.resolve();

  constructor(view: HTMLElement, mapBox: HTMLElement) {
    this.view = view;
    this.mapBox = mapBox;
  }

  /** Shows a work's path or walk from its start. Returns the fly-through, and a button for its object if it has one. */
  show(work: Work): Promise<HTMLElement[]> {
    const shown = this.showing.then(() => this.present(work));
    this.showing = shown.catch(() => {}); // its caller hears of it
    return shown;
  }

  private async present(work: Work): Promise<HTMLElement[]> {
    this.player?.dispose();
    this.outlines?.dispose();
    const ids = work.path ?? (work.steps ?? work.turns ?? []).map(({ viewpoint }) => viewpoint);
    if (this.viewer?.scan.scan !== work.scan) await this.open(work.scan);
    const viewer = this.viewer!;
    const path = ids.map((id) => viewpointIndex(viewer.scan, id))
      .filter((v, k, all) => v !== all[k - 1]);
    await viewer.jump({ viewpoint: path[0]!, heading: work.heading, elevation: 0 });
    viewer.setPath(path);
    this.map!.setPath(work.path ? path : [], work.path ? [] : path);
    this.player = new Player(viewer, path);
    this.outlines = work.object && new Outlines(viewer, outlinesIn(viewer.scan, work.object));
    this.outlines?.setPoint(work.point, path.at(-1));
    return [this.player.element, ...(this.outlines ? [this.outlines.button] : [])];
  }

  private async open(scan: string): Promise<void> {
    this.map?.dispose();
    this.viewer?.dispose();
    this.viewer = await Viewer.open(this.view, { scan });
    this.map = new MiniMap(this.viewer);
    void this.map.loadPlan(api, true);
    this.mapBox.replaceChildren(this.map.element);
  }
}
