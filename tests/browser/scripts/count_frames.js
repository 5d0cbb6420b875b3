// How often the picture before rectification is drawn within two seconds.
() =>
  new Promise((resolve) => {
    const draw = CanvasRenderingContext2D.prototype.drawImage;
    const before = document.querySelector(".compare canvas");
    let count = 0;
    CanvasRenderingContext2D.prototype.drawImage = function (...rest) {
      if (this.canvas === before) count += 1;
      return draw.apply(this, rest);
    };
    setTimeout(() => {
      CanvasRenderingContext2D.prototype.drawImage = draw;
      resolve(count);
    }, 2000);
  });
