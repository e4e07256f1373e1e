'use strict';

// Examples of instructions, panoramas, floor plans.

function picture(source, description) {
  return element('img', {src: source, alt: description, loading: 'lazy', decoding: 'async'});
}

function drawExamples(section, data) {
  const part = data.examples;
  section.append(paragraph(`Paths of ${part.split} at random: what is seen at the start, and how ` +
    'three people describe the way.'.replace('people', data.about.synthetic ? 'speakers' : 'people'),
    'lead'));
  if (part.noPictures) leaveOut('The view from the start', part.noPictures);
  const list = element('div', {class: 'pictures'});
  for (const path of part.paths) {
    const item = element('figure', {class: 'example'});
    if (path.picture) item.append(picture(path.picture, `View from the start of path ${path.path}`));
    item.append(element('figcaption', {}, `${path.scan}, path ${path.path}, heading ${path.heading}°`));
    const texts = element('ol');
    for (const text of path.instructions) texts.append(element('li', {}, text.trim()));
    item.append(texts);
    list.append(item);
  }
  section.append(list);
}

function drawPanoramas(section, data) {
  const part = data.panoramas;
  const some = part.panoramas.length < part.buildings
    ? `${part.panoramas.length} of ${part.buildings} buildings` +
      (part.leastTexels ? `, of those with pictures of ${part.leastTexels} texels a face or more` : '')
    : `The ${part.buildings} buildings`;
  section.append(paragraph(`${some}, each from the viewpoint with most neighbours, in all ` +
    'directions at once.', 'lead'));
  const list = element('div', {class: 'pictures wide'});
  for (const one of part.panoramas) {
    list.append(element('figure', {}, picture(one.picture, `Panorama of building ${one.scan}`),
      element('figcaption', {}, `${one.scan}, ${one.viewpoints} viewpoints`)));
  }
  section.append(list);
}

function drawPlans(section, data) {
  const part = data.plans;
  section.append(paragraph(`Episodes of ${agentName(part.agent)} on ${part.split}: the reference ` +
    'path as a band, the agent’s way as a line that darkens with time.', 'lead'));
  const list = element('div', {class: 'pictures'});
  for (const plan of part.plans) {
    list.append(element('figure', {class: 'plan'},
      picture(plan.picture, `Floor plan of ${plan.scan} with episode ${plan.episode}`),
      element('figcaption', {}, `${plan.kind}: ${plan.scan}, episode ${plan.episode}`)));
  }
  section.append(list);
}

// Of walks in continuous space: a map from above with the lines of all agents.
function drawWalks(section, data) {
  const part = data.walks;
  section.append(paragraph(`Episodes of ${part.split}: the reference path as a band with the ring ` +
    'of success at its end, each agent’s way as a line that darkens with time. Best and worst are ' +
    `by where ${agentName(part.agent)} stopped.`, 'lead'));
  const list = element('div', {class: 'pictures'});
  for (const walk of part.walks) {
    list.append(element('figure', {class: 'plan'},
      picture(walk.picture, `Map of ${walk.scan} from above with the walks of episode ${walk.episode}`),
      element('figcaption', {}, `${walk.kind}: ${walk.scan}, episode ${walk.episode}: ` +
        walk.agents.map((one) => `${agentName(one.agent)} ${one.distance === null ? 'out of reach'
          : `${one.distance.toFixed(1)} m`}${one.success ? ', success' : ''}`).join('; '))));
  }
  section.append(list);
}
