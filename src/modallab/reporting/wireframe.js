// Moves structures of lines: r(t) = rest + Re((p + j q) exp(j 2 pi t / T)), p and q being each point's parts in the plane.
for (const box of document.querySelectorAll(".wireframes")) {
  const drawings = [...box.querySelectorAll("svg")].map((svg) => ({
    period: Number(svg.dataset.period),
    points: JSON.parse(svg.dataset.points),
    lines: JSON.parse(svg.dataset.lines),
    faces: JSON.parse(svg.dataset.faces),
    beam: svg.querySelector(".beam"),
    shade: svg.querySelector(".faces"),
    dots: svg.querySelector(".dots"),
  }));
  const draw = (seconds) => {
    for (const { period, points, lines, faces, beam, shade, dots } of drawings) {
      const c = Math.cos((2 * Math.PI * seconds) / period);
      const s = Math.sin((2 * Math.PI * seconds) / period);
      const at = points.map(
        ([x, y, px, py, qx, qy]) => `${(x + px * c - qx * s).toFixed(1)} ${(y + py * c - qy * s).toFixed(1)}`,
      );
      beam.setAttribute("d", lines.map(([a, b]) => `M${at[a]}L${at[b]}`).join(""));
      shade.setAttribute("d", faces.map((face) => `M${face.map((n) => at[n]).join("L")}Z`).join(""));
      dots.setAttribute("d", at.map((a) => `M${a}h0`).join(""));
    }
  };
  swing(box, draw);
}
