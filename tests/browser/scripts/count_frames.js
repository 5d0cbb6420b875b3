// How often the picture before rectification is drawn: twice, unless that takes a minute.
() =>
  new Promise((resolve) => {
    const draw = CanvasRenderingContext2D.prototype.drawImage;
    const before = document.querySelector(".compare canvas");
    let count = 0;
    const end = () => {
      CanvasRenderingContext2D.prototype.drawImage = draw;
      resolve(count);
    };
    CanvasRenderingContext2D.prototype.drawImage = function (...rest) {
      if (this.canvas === before && ++count === 2) end();
      return draw.apply(this, rest);
    };
    setTimeout(end, 60_000);
  });
