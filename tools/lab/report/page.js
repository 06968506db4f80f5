// The picture comparison, and tables that open themselves for the printer.
for (const figure of document.querySelectorAll(".compare")) {
  const stage = figure.querySelector(".stage"), range = figure.querySelector("input[type=range]");
  if (!stage) continue;
  const images = JSON.parse(figure.querySelector(".store").textContent);
  const title = figure.querySelector("h3").textContent;
  const cut = () => stage.style.setProperty("--cut", range.value + "%");
  range.addEventListener("input", cut);
  cut();

  for (const side of ["left", "right"]) {
    const select = figure.querySelector(".choose-" + side), picture = figure.querySelector("img." + side);
    const choose = () => {
      const image = images[select.value];
      picture.src = image.uri;
      picture.alt = title + ", " + image.caption;
      figure.querySelector(".says-" + side).textContent = image.caption;
    };
    select.addEventListener("change", choose);
    choose();  // a browser may have kept an earlier choice
  }

  const follow = event => {
    const box = stage.getBoundingClientRect();
    range.value = 100 * (event.clientX - box.left) / box.width;
    cut();
  };
  stage.addEventListener("pointerdown", event => { stage.setPointerCapture(event.pointerId); follow(event); });
  stage.addEventListener("pointermove", event => { if (stage.hasPointerCapture(event.pointerId)) follow(event); });
}

const closed = new Set();
addEventListener("beforeprint", () => {
  for (const d of document.querySelectorAll("details:not([open])")) closed.add(d), d.open = true;
});
addEventListener("afterprint", () => {
  for (const d of closed) d.open = false;
  closed.clear();
});
