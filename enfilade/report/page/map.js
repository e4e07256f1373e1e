'use strict';

// The map of a gallery's episode: its building's graph from above, north up, one storey at a time.

const kFieldOfView = 75.2;  // degrees, of the agents' camera from left to right

// All of the building, and the circle around the goal.
function mapScale(building, goal, around, width, height) {
  const shown = building.storey.map((s, i) => i).filter((i) => building.storey[i] !== null);
  const ends = building.plan.flatMap((storey) => storey.lines.walls || []);
  const extent = (values, axis) => d3.extent([...shown.map((i) => values[i]),
    ...ends.filter((end, k) => k % 2 === axis), values[goal] - around, values[goal] + around]);
  const [left, right] = extent(building.x, 0);
  const [bottom, top] = extent(building.y, 1);
  const border = 18;
  const scale = Math.min((width - 2 * border) / Math.max(right - left, 1),
    (height - 2 * border) / Math.max(top - bottom, 1), 60);
  const x0 = width / 2 - scale * (left + right) / 2;
  const y0 = height / 2 + scale * (bottom + top) / 2;
  const point = (x, y) => [x0 + scale * x, y0 - scale * y];
  return {scale, point, at: (v) => point(building.x[v], building.y[v])};
}

// Furniture first, walls over it, and the rooms' names. Nothing where the data set tells of none.
function drawPlan(svg, building, place, storey) {
  const plan = building.plan[storey];
  if (!plan) return;
  for (const kind of ['furniture', 'stairs', 'windows', 'doors', 'walls']) {
    const ends = plan.lines[kind] || [];
    let path = '';
    for (let k = 0; k + 3 < ends.length; k += 4) {
      const from = place.point(ends[k], ends[k + 1]).map((p) => p.toFixed(1));
      const to = place.point(ends[k + 2], ends[k + 3]).map((p) => p.toFixed(1));
      path += `M${from}L${to}`;
    }
    if (path) svg.append('path').attr('class', `plan-line ${kind}`).attr('d', path);
  }
  for (const [name, x, y] of plan.names) {
    const [left, top] = place.point(x, y);
    svg.append('text').attr('class', 'room').attr('x', left).attr('y', top).text(name);
  }
}

function drawBuilding(svg, building, place, storey) {
  const far = (...vs) => vs.every((v) => building.storey[v] !== storey) ? ' elsewhere' : '';
  for (const [a, b] of building.edges) {
    const [x1, y1] = place.at(a);
    const [x2, y2] = place.at(b);
    svg.append('line').attr('class', `edge${far(a, b)}`)
      .attr('x1', x1).attr('y1', y1).attr('x2', x2).attr('y2', y2);
  }
  building.storey.forEach((s, v) => {
    if (s === null) return;
    const [x, y] = place.at(v);
    svg.append('circle').attr('class', `place${far(v)}`).attr('r', 2).attr('cx', x).attr('cy', y);
  });
}

function drawWay(svg, place, viewpoints, kind) {
  if (viewpoints.length > 1) {
    svg.append('path').attr('class', kind).attr('d', d3.line()(viewpoints.map(place.at)));
  }
}

function drawGoal(svg, place, viewpoint, distance, name) {
  const [x, y] = place.at(viewpoint);
  svg.append('circle').attr('class', 'goal').attr('r', distance * place.scale)
    .attr('cx', x).attr('cy', y);
  svg.append('path').attr('class', 'end')
    .attr('d', d3.symbol().type(d3.symbolStar).size(130)())
    .attr('transform', `translate(${x},${y})`).append('title').text(name);
}

// Squares on who sees an object, a diamond where one turns, discs of a region's floor.
function drawMarks(svg, place, goal) {
  const symbol = {'turning point': d3.symbolDiamond2 || d3.symbolDiamond, region: d3.symbolCircle}[goal.kind] ||
    d3.symbolSquare;
  for (const v of goal.viewpoints) {
    const [x, y] = place.at(v);
    svg.append('path').attr('class', 'seen')
      .attr('d', d3.symbol().type(symbol).size(goal.kind === 'region' ? 220 : 90)())
      .attr('transform', `translate(${x},${y})`).append('title').text(goal.label);
  }
}

function drawAgent(svg, place, step) {
  const [x, y] = place.at(step.v);
  const half = kFieldOfView / 2 * Math.PI / 180;
  const sight = d3.arc().innerRadius(0).outerRadius(34)
    .startAngle(step.heading - half).endAngle(step.heading + half);
  svg.append('path').attr('class', 'sight').attr('d', sight())
    .attr('transform', `translate(${x},${y})`);
  svg.append('circle').attr('class', 'here').attr('r', 6).attr('cx', x).attr('cy', y);
}

function drawScaleBar(svg, place, width, height) {
  const length = [10, 5, 2, 1].find((m) => m * place.scale < width / 3) || 1;
  const right = width - 14;
  svg.append('path').attr('class', 'baseline').attr('fill', 'none')
    .attr('d', `M${right - length * place.scale},${height - 12}H${right}`);
  svg.append('text').attr('text-anchor', 'end').attr('x', right).attr('y', height - 17)
    .text(`${length} m`);
}

function drawMap(episode, building, index, successDistance) {
  const width = 420;
  const height = 315;
  const step = episode.steps[index];
  const goal = episode.reference[episode.reference.length - 1];
  const place = mapScale(building, goal, successDistance, width, height);
  const svg = d3.create('svg').attr('class', 'map').attr('role', 'img')
    .attr('viewBox', `0 0 ${width} ${height}`)
    .attr('aria-label', `Map of ${episode.scan} at step ${index}`);
  const storey = building.storey[step.v];
  drawPlan(svg, building, place, storey);
  drawBuilding(svg, building, place, storey);
  drawWay(svg, place, episode.reference, 'path');
  const last = episode.steps.length - 1;
  const walked = wayUntil(episode, index);
  const chooses = episode.steps.some((s) => s.choices);
  if (chooses) drawKnown(svg, building, place, episode, index);
  else drawWay(svg, place, wayUntil(episode, last).slice(walked.length - 1), 'to-walk');
  drawWay(svg, place, walked, 'walked');
  if (episode.goal) drawMarks(svg, place, episode.goal);
  const near = !episode.goal || episode.goal.kind === 'turning point';
  drawGoal(svg, place, goal, near ? successDistance : 0, near ? 'goal' : 'end of the reference path');
  drawAgent(svg, place, step);
  drawChoices(svg, place, step);
  drawScaleBar(svg, place, width, height);
  svg.append('text').attr('x', 12).attr('y', height - 12).text('north is up' +
    (building.storeys > 1 ? `; storey ${storey + 1} of ${building.storeys}` : ''));
  return svg.node();
}
