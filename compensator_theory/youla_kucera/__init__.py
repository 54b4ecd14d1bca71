"""All stabilising compensators: doubly coprime fractions and the parameter of Youla and Kucera."""
