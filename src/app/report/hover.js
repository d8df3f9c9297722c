// The values under the pointer, read off the lines as they are drawn: the page holds no numbers twice.
(() => {
  const note = document.body.appendChild(document.createElement('div'));
  note.className = 'note';
  const short = value => String(Number(value.toPrecision(4)));
  const SVG = 'http://www.w3.org/2000/svg';
  // From a place of the page to the value of an axis, in words.
  const said = (axis, at) => {
    const measured = axis.from + (at - axis.low) / (axis.high - axis.low) * (axis.to - axis.from);
    if (axis.names) return axis.names[Math.round(measured)] ?? '';
    return `${short(axis.log ? 10 ** measured : measured)} ${axis.unit}`.trim();
  };
  const number = (element, key) => Number(element.getAttribute(key));
  // What a series can be asked for: y on the page at [x, y] of the page, or undefined.
  const parts = (series, zero) => {
    const found = [];
    for (const path of series.querySelectorAll('path[fill=none]')) {
      const points = path.getAttribute('d').slice(1).split('L').map(point => point.split(' ').map(Number));
      found.push((x, y) => points.slice(1).map(([toX, toY], before) => {
        const [fromX, fromY] = points[before];
        const part = toX === fromX ? 0.5 : (x - fromX) / (toX - fromX);
        return part < 0 || part > 1 || (toX === fromX && toX !== x) ? undefined : [x, fromY + part * (toY - fromY)];
      }));
    }
    const dots = [...series.querySelectorAll('circle')].map(dot => [number(dot, 'cx'), number(dot, 'cy')]);
    found.push((x, y) => dots.filter(dot => Math.hypot(dot[0] - x, dot[1] - y) < 8));
    for (const bar of series.querySelectorAll('rect')) {
      const [left, top] = [number(bar, 'x'), number(bar, 'y')];
      const [right, bottom] = [left + number(bar, 'width'), top + number(bar, 'height')];
      const end = Math.abs(top - zero) > Math.abs(bottom - zero) ? top : bottom;
      found.push(x => left <= x && x <= right ? [[(left + right) / 2, end]] : []);
    }
    return (x, y) => {
      const hits = found.flatMap(part => part(x, y)).filter(hit => hit);
      const far = hit => Math.hypot(hit[0] - x, hit[1] - y);
      return hits.reduce((best, hit) => !best || far(hit) < far(best) ? hit : best, undefined);
    };
  };
  for (const plot of document.querySelectorAll('g[data-x]')) {
    const picture = plot.ownerSVGElement, marks = plot.parentNode.insertBefore(document.createElementNS(SVG, 'g'), plot.nextSibling);
    const [across, up] = [plot.dataset.x, plot.dataset.y].map(JSON.parse);
    const zero = up.log ? up.low : up.low + (0 - up.from) / (up.to - up.from) * (up.high - up.low);
    let all;
    const hide = () => { note.style.display = 'none'; marks.replaceChildren(); };
    picture.addEventListener('pointerleave', hide);
    picture.addEventListener('pointermove', event => {
      const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(picture.getScreenCTM().inverse());
      if (at.x < across.low || at.x > across.high || at.y < up.high || at.y > up.low) return hide();
      all ??= [...plot.querySelectorAll('g[data-series]:not([data-series=""])')].map(series => [series.dataset.series, parts(series, zero)]);
      const hits = all.map(([name, ask]) => [name, ask(at.x, at.y)]).filter(([, hit]) => hit);
      const here = hits.length ? [] : [`${up.label} ${said(up, at.y)}`.trim()];
      const lines = [`${across.label} ${said(across, at.x)}`, ...here, ...hits.map(([name, hit]) => `${name}: ${said(up, hit[1])}`)];
      note.replaceChildren(...lines.map(line => Object.assign(document.createElement('div'), { textContent: line })));
      Object.assign(note.style, { display: 'block', left: `${event.pageX + 14}px`, top: `${event.pageY + 14}px` });
      marks.replaceChildren(...hits.map(([, hit]) => {
        const dot = document.createElementNS(SVG, 'circle');
        [['cx', hit[0]], ['cy', hit[1]], ['r', 2], ['fill', 'none'], ['stroke', '#1a1a1a']].forEach(([key, value]) => dot.setAttribute(key, value));
        return dot;
      }));
    });
  }
})();
