// Opens films when the panel of their cell is shown, and takes the keyboard's focus there and back.
// Without it everything but the films works.
(() => {
  "use strict";
  let shown = null;

  function openFilm(video) {
    const holder = document.getElementById(video.dataset.film);
    if (video.src || !holder) return;
    const text = atob(holder.textContent.trim());
    const bytes = new Uint8Array(text.length);
    for (let n = 0; n < text.length; ++n) bytes[n] = text.charCodeAt(n);
    video.src = URL.createObjectURL(new Blob([bytes], {type: holder.dataset.type}));
    holder.remove();  // its text is in the blob now
  }

  function follow(event) {
    const target = document.getElementById(decodeURIComponent(location.hash.slice(1)));
    const panel = target && target.classList.contains("panel") ? target : null;
    if (shown && shown !== panel) {
      for (const video of shown.querySelectorAll("video")) video.pause();
    }
    for (const link of document.querySelectorAll(".map a[aria-current]")) {
      link.removeAttribute("aria-current");
    }
    const closed = shown;
    shown = panel;
    if (panel) {
      panel.querySelectorAll("video[data-film]").forEach(openFilm);
      linkTo(panel).setAttribute("aria-current", "true");
      panel.focus({preventScroll: true});
    } else if (closed && event && target && target.id === "map") {
      linkTo(closed).focus({preventScroll: true});
    }
    // What is in a closed <details> is not shown by being the target.
    const around = target && target.closest("details");
    if (around && !around.open) {
      around.open = true;
      target.scrollIntoView();
    }
  }

  function linkTo(panel) {
    return document.querySelector(`.map a[href="#${panel.id}"]`);
  }

  addEventListener("hashchange", follow);
  addEventListener("keydown", event => {
    if (event.key === "Escape" && shown && !document.fullscreenElement) location.hash = "#map";
  });
  follow();
})();
