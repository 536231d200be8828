// Moves the mode shapes: y(t) = Re((p + j q) exp(j 2 pi t / T)), p and q being each point's parts in and out of step.
for (const box of document.querySelectorAll(".motion")) {
  const beams = [...box.querySelectorAll("svg")].map((svg) => ({
    period: Number(svg.dataset.period),
    paths: [...svg.querySelectorAll("[data-p]")].map((path) => ({
      path,
      dots: path.classList.contains("dots"),
      points: JSON.parse(path.dataset.p),
    })),
  }));
  const draw = (seconds) => {
    for (const { period, paths } of beams) {
      const c = Math.cos((2 * Math.PI * seconds) / period);
      const s = Math.sin((2 * Math.PI * seconds) / period);
      for (const { path, dots, points } of paths) {
        const at = points.map(([x, p, q]) => `${x} ${(p * c - q * s).toFixed(2)}`);
        path.setAttribute("d", dots ? at.map((a) => `M${a}h0`).join("") : `M${at.join("L")}`);
      }
    }
  };
  swing(box, draw);
}
