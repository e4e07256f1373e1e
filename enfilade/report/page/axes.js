'use strict';

// An empty chart with labelled axes, to draw on.
// spec: {width, height, title, description, x, y}; an axis: {domain, label, ticks, format}.
function makeChart(spec) {
  const width = spec.width || 360;
  const height = spec.height || 240;
  const margin = {top: spec.title ? 26 : 10, right: 18, bottom: 42, left: 58, ...spec.margin};
  const svg = d3.create('svg')
    .attr('viewBox', `0 0 ${width} ${height}`)
    .attr('class', 'chart')
    .attr('role', 'img')
    .attr('aria-label', spec.description);
  const x = d3.scaleLinear(spec.x.domain, [margin.left, width - margin.right]);
  const y = d3.scaleLinear(spec.y.domain, [height - margin.bottom, margin.top]);
  drawYAxis(svg, y, spec.y, width, margin);
  drawXAxis(svg, x, spec.x, height, margin);
  if (spec.title) {
    svg.append('text').attr('class', 'title').attr('x', margin.left).attr('y', 14).text(spec.title);
  }
  return {svg, x, y, width, height, margin, plot: svg.append('g')};
}

function drawYAxis(svg, y, axis, width, margin) {
  const ticks = svg.append('g').attr('class', 'axis')
    .attr('transform', `translate(${margin.left},0)`)
    .call(d3.axisLeft(y).ticks(axis.ticks || 5).tickFormat(axis.format || null)
      .tickSizeInner(-(width - margin.left - margin.right)).tickSizeOuter(0).tickPadding(6));
  plainText(ticks);
  const [low, high] = y.range();
  svg.append('text').attr('text-anchor', 'middle')
    .attr('transform', `translate(13,${(low + high) / 2}) rotate(-90)`).text(axis.label);
}

function drawXAxis(svg, x, axis, height, margin) {
  const bottom = height - margin.bottom;
  const [left, right] = x.range();
  const ticks = svg.append('g').attr('class', 'axis').attr('transform', `translate(0,${bottom})`)
    .call(d3.axisBottom(x).ticks(axis.ticks || 5).tickFormat(axis.format || null)
      .tickSize(4).tickSizeOuter(0).tickPadding(4));
  plainText(ticks);
  svg.append('line').attr('class', 'baseline')
    .attr('x1', left).attr('x2', right).attr('y1', bottom).attr('y2', bottom);
  svg.append('text').attr('text-anchor', 'middle')
    .attr('x', (left + right) / 2).attr('y', height - 7).text(axis.label);
}

// D3 gives its ticks a font and a colour of its own.
function plainText(ticks) {
  ticks.attr('font-size', null).attr('font-family', null).attr('fill', null);
  ticks.selectAll('text').attr('fill', null);
  ticks.selectAll('line').attr('stroke', null);
}

function drawLine(chart, points, kind, title) {
  const line = d3.line().x((p) => chart.x(p[0])).y((p) => chart.y(p[1]));
  chart.plot.append('path').attr('class', `line ${kind}`).attr('d', line(points))
    .append('title').text(title);
}

// A level to compare with, named at its right end.
function drawLevel(chart, value, name) {
  const y = chart.y(value);
  const right = chart.width - chart.margin.right;
  chart.plot.append('line').attr('class', 'reference')
    .attr('x1', chart.margin.left).attr('x2', right).attr('y1', y).attr('y2', y);
  chart.plot.append('text').attr('text-anchor', 'end').attr('x', right).attr('y', y - 4).text(name);
}

function drawMark(chart, value, name) {
  const x = chart.x(value);
  const top = chart.margin.top;
  chart.plot.append('line').attr('class', 'reference')
    .attr('x1', x).attr('x2', x).attr('y1', top).attr('y2', chart.height - chart.margin.bottom);
  chart.plot.append('text').attr('x', x + 4).attr('y', top + 10).text(name);
}
